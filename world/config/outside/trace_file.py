"""The file of a trace: time, sender, receiver, and probability or decoded."""

import csv
import hashlib
import io
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from fes.arrays.types import Floats, Ints
from fes.errors import FesError, ScenarioError, reason
from fes.system import files

LARGEST = 1 << 28
"""Largest trace that is read [bytes]."""

VALUES = ("probability", "decoded")


class Trace(NamedTuple):
    """The rows of a trace [k]."""

    time: Floats
    """[s]"""
    sender: Ints
    receiver: Ints
    probability: Floats
    """1 or 0 for a beacon that decoded or was lost."""


def locate(tables: dict[str, Any], path: Path) -> None:
    """Make the path of a trace absolute, and fill in its checksum; raises ScenarioError."""
    channel = tables.get("channel")
    if not isinstance(channel, dict) or not isinstance(channel.get("trace"), str):
        return
    channel["trace"] = str((path.parent / channel["trace"]).resolve())
    try:
        channel.setdefault("trace_sha256", checksum(channel["trace"]))
    except FesError as error:
        raise ScenarioError(str(path), f"channel.trace: {error}") from None


def checksum(path: str) -> str:
    """SHA-256 of a trace; raises FesError."""
    return hashlib.sha256(_bytes(path)).hexdigest()


@lru_cache(maxsize=4)
def read(path: str, sha256: str | None) -> Trace:
    """The rows of a trace; raises FesError in one line, also where its checksum is not `sha256`."""
    content = _bytes(path)
    actual = hashlib.sha256(content).hexdigest()
    if sha256 is not None and actual != sha256:
        raise FesError(f"{path} has changed: its SHA-256 is {actual[:12]}..., the scenario has {sha256[:12]}...")
    try:
        rows = csv.DictReader(io.StringIO(content.decode("utf-8-sig")), skipinitialspace=True)
    except UnicodeDecodeError:
        raise FesError(f"{path} is not text in UTF-8") from None
    names = [name.strip() for name in rows.fieldnames or ()]
    value = next((name for name in VALUES if name in names), None)
    missing = [name for name in ("time", "sender", "receiver") if name not in names]
    if missing or value is None:
        raise FesError(f"{path}: its first line must name time, sender, receiver, and probability or decoded")
    rows.fieldnames = names
    table = np.array([_row(path, number, row, value) for number, row in enumerate(rows, 2)]).reshape(-1, 4)
    ids = table[:, 1:3].astype(np.int64)
    return Trace(table[:, 0], ids[:, 0], ids[:, 1], table[:, 3])


def _row(path: str, number: int, row: dict[str, str], value: str) -> tuple[float, float, float, float]:
    """The numbers of one row; raises FesError that names its line."""
    try:
        numbers = float(row["time"]), int(row["sender"]), int(row["receiver"]), float(row[value])
    except (TypeError, ValueError):
        raise FesError(f"{path}, line {number}: expects numbers, got {str(dict(row))[:80]}") from None
    if not (0.0 <= numbers[3] <= 1.0 and abs(numbers[0]) < 1e12 and min(numbers[1:3]) >= 0):
        raise FesError(f"{path}, line {number}: expects a time, two ids and a {value} from 0 to 1, got {numbers}")
    return numbers


def _bytes(path: str) -> bytes:
    try:
        return files.read(Path(path), LARGEST)
    except OSError as error:
        raise FesError(f"trace {path} cannot be read: {reason(error, with_file=False)}") from None
