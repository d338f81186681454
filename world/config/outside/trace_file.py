"""The file of a trace: time, sender, receiver, and probability or decoded."""

import hashlib
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from fes.arrays.types import Floats, Ints
from fes.errors import FesError, ScenarioError, reason
from fes.system import files, number_columns
from fes.system.number_columns import Column

LARGEST = 1 << 28
"""Largest trace that is read [bytes]."""

LATEST = 1e9
"""Largest time of a row [s], as of an event."""

TRACE, CHECKSUM = "trace", "trace_sha256"
"""Keys of the channel: path and checksum of the file."""

_IDS = 2**31 - 1

_COLUMNS = (
    (Column("time", -LATEST, LATEST),),
    (Column("sender", 0, _IDS, is_whole=True),),
    (Column("receiver", 0, _IDS, is_whole=True),),
    (Column("probability", 0, 1), Column("decoded", 0, 1, is_whole=True)),
)


class Trace(NamedTuple):
    """The rows of a trace [k]."""

    time: Floats
    """[s]"""
    sender: Ints
    receiver: Ints
    probability: Floats
    """1 or 0 for a beacon that decoded or was lost."""


_parsed: dict[str, Trace] = {}  # the rows of the latest file, by its checksum: a load and a run read the same file


def read(path: str, sha256: str) -> Trace:
    """The rows of a trace; raises FesError in one line, also where its checksum is not `sha256`."""
    content = _content(path)
    actual = _checksum(content)
    if actual != sha256:
        raise FesError(f"{path} has changed: its SHA-256 is {actual[:12]}..., the scenario has {sha256[:12]}...")
    if sha256 not in _parsed:
        time, sender, receiver, value = number_columns.read(path, content, _COLUMNS).values()
        _parsed.clear()
        _parsed[sha256] = Trace(time, sender.astype(np.int64), receiver.astype(np.int64), value)
    return _parsed[sha256]


def anchored(overrides: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """Overrides whose path of a trace starts from `folder`, and which drop the checksum of the former file."""
    given = overrides.get(f"channel.{TRACE}")
    if not isinstance(given, str):
        return dict(overrides)
    return {f"channel.{CHECKSUM}": None, **overrides, f"channel.{TRACE}": os.path.abspath(folder / given)}


def locate(tables: dict[str, Any], folder: Path, where: str) -> None:
    """Make the paths of all traces of a scenario absolute, from `folder`, and fill in missing checksums.

    A checksum that the scenario has must be that of the file. Raises ScenarioError, which names their origin `where`.
    """
    events = tables.get("event")
    try:
        _locate(tables.get("channel"), "", folder)
        for event in events if isinstance(events, list) else []:
            if isinstance(event, dict):
                _locate(event.get("set"), "channel.", folder)
    except FesError as error:
        raise ScenarioError(where, f"channel.{TRACE}: {error}") from None


def _locate(table: Any, prefix: str, folder: Path) -> None:
    if not isinstance(table, dict) or not isinstance(table.get(prefix + TRACE), str):
        return
    path = os.path.abspath(folder / table[prefix + TRACE])
    table[prefix + TRACE] = path
    checksum = table.get(prefix + CHECKSUM)
    if checksum is None:
        table[prefix + CHECKSUM] = checksum = _checksum(_content(path))
    if isinstance(checksum, str):
        read(path, checksum)


def _checksum(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def _content(path: str) -> bytes:
    try:
        return files.read(Path(path), LARGEST)
    except (OSError, ValueError) as error:  # a path may hold a null character
        text = reason(error, with_file=False) if isinstance(error, OSError) else str(error)
        raise FesError(f"trace {path} cannot be read: {text}") from None
