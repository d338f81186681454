"""The result of one check."""

from enum import StrEnum
from typing import NamedTuple


class Status(StrEnum):
    """The outcome of a check."""

    OK = "ok"
    WARNING = "warning"
    FAILED = "failed"


class Finding(NamedTuple):
    """The result of one check; `remedy` says what a person can do, and is empty if the check passed."""

    check: str
    status: Status
    seen: str
    remedy: str = ""


def ok(check: str, seen: str) -> Finding:
    """A check that passed."""
    return Finding(check, Status.OK, seen)


def warning(check: str, seen: str, remedy: str) -> Finding:
    """A check that found a possible problem, with which a run can still succeed."""
    return Finding(check, Status.WARNING, seen, remedy)


def failed(check: str, seen: str, remedy: str) -> Finding:
    """A check that found a problem with which no run can succeed."""
    return Finding(check, Status.FAILED, seen, remedy)
