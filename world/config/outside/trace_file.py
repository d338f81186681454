"""The file of a trace: time, sender, receiver, and probability or decoded."""

import hashlib
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from fes.arrays.types import Floats, Ints
from fes.errors import FesError, reason
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


def locate(tables: dict[str, Any], folder: Path, overrides: Mapping[str, Any]) -> None:
    """Make the paths of all traces of a scenario absolute, and fill in missing checksums.

    A path in the scenario starts from `folder`, that of an override from the current directory. A checksum that the
    scenario has must be that of the file. Raises FesError in one line.
    """
    given, channel = overrides.get(f"channel.{TRACE}"), tables.get("channel")
    if isinstance(given, str) and isinstance(channel, dict):
        channel[TRACE] = str(Path.cwd() / given)
        channel[CHECKSUM] = overrides.get(f"channel.{CHECKSUM}")
    _locate(tables.get("channel"), "", folder)
    events = tables.get("event")
    for event in events if isinstance(events, list) else []:
        if isinstance(event, dict):
            _locate(event.get("set"), "channel.", folder)


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
