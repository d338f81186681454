"""One check and what it saw."""

from enum import StrEnum
from typing import NamedTuple


class Status(StrEnum):
    """How a check ended."""

    OK = "ok"
    WARNING = "warning"
    FAILED = "failed"


class Finding(NamedTuple):
    """What one check saw; `remedy` says what a person can do about it, and is empty where all is well."""

    check: str
    status: Status
    seen: str
    remedy: str = ""


def ok(check: str, seen: str) -> Finding:
    """All is well."""
    return Finding(check, Status.OK, seen)


def warning(check: str, seen: str, remedy: str) -> Finding:
    """Something that a person should know; a run may still go well."""
    return Finding(check, Status.WARNING, seen, remedy)


def failed(check: str, seen: str, remedy: str) -> Finding:
    """A run cannot go well."""
    return Finding(check, Status.FAILED, seen, remedy)
