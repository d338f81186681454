"""What is done, kept through every interruption: one line a run, appended when the run has ended.

A line that a kill tore off is dropped, and its run is run again; a run has one line, by its key. Each line ends with
a checksum of the text before it. All runs of a directory were computed with one arithmetic.
"""

import contextlib
import fcntl
import hashlib
import os
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import IO, Any

from console.sweep.design import Design, digest, seeded
from console.sweep.work import Done
from fes.errors import FesError, reason
from fes.protocol.world_info import version
from fes.system import encoding, files, fingerprint, strict_json

HEADER = "sweep.json"
LINES = "runs.jsonl"

FORMAT = 2
"""Format of the two files; the first format had no number, no arithmetic and no checksums."""

_MAX_LINE = 1 << 24  # bytes; a run has 2 kB
_MAX_HEADER = 1 << 26  # bytes; the axes may have a million values

_DIFFERS = {
    "scenario": "another scenario",
    "axes": "other axes",
    "fes": "another version of fes",
    "cells": "another scenario",
    "arithmetic": "another arithmetic",
}


@dataclass(eq=False)
class Ledger:
    """An open ledger."""

    done: dict[str, Done]
    """By run key."""
    _file: IO[bytes]

    def add(self, ended: Sequence[Done]) -> None:
        """Keep what these runs came to; it is on the disk when this returns."""
        fresh = {one.key: one for one in ended if one.key not in self.done}
        self._file.write(b"".join(map(_line, fresh.values())))
        self._file.flush()
        os.fsync(self._file.fileno())
        self.done |= fresh

    def read_again(self) -> None:
        """Know what is on the disk: a signal may have come while it was written."""
        self._file.flush()
        self.done = _read(self._file, Path(self._file.name))


def default_directory(design: Design) -> Path:
    """Where the same command finds its sweep again."""
    return Path("sweeps") / f"{encoding.file_name(design.name)}-{_identity(design)['cells'][:8]}"


@contextlib.contextmanager
def opened(directory: Path, design: Design) -> Iterator[Ledger]:
    """The ledger of a design in a directory, a new one or one to go on with; raises FesError if it is another's."""
    with contextlib.ExitStack() as stack:
        try:
            directory.mkdir(parents=True, exist_ok=True)
            _claim(directory, design)
            file = stack.enter_context((directory / LINES).open("a+b"))
            _lock(file, directory)
            done = _read(file, directory / LINES)
        except OSError as error:
            raise FesError(f"cannot keep a sweep: {reason(error)}") from None
        yield Ledger(done, file)


def _identity(design: Design) -> dict[str, Any]:
    """What one directory may hold the runs of; more seeds are the same sweep."""
    cells = "".join(digest(seeded(cell.scenario, 0)) for cell in design.cells)
    axes = {field: design.values(at) for at, field in enumerate(design.axes)}
    return {
        "scenario": design.name,
        "axes": axes,
        "cells": hashlib.sha256(cells.encode()).hexdigest(),
        "fes": version(),
        "arithmetic": fingerprint.text(),
        "format": FORMAT,
    }


def _claim(directory: Path, design: Design) -> None:
    """Write the directory's header, or find that it is this design's."""
    path, wanted = directory / HEADER, _identity(design)
    if not path.exists():
        temporary = directory / f".{HEADER}"
        if any(found != temporary for found in directory.iterdir()):  # that one a kill may have left behind
            raise FesError(f"--out {directory}: the directory is not empty, and no sweep's")
        temporary.write_text(strict_json.dumps(wanted, indent=1) + "\n", encoding="utf-8")
        os.replace(temporary, path)
        return
    found = files.read_table(path, _MAX_HEADER)
    before = found.get("format", 1)
    if before != FORMAT:
        raise FesError(
            f"--out {directory}: it holds a sweep of format {before!r:.20}; this fes reads format {FORMAT}"
        )
    for name, what in _DIFFERS.items():
        if found.get(name) != wanted[name]:
            told = f"{strict_json.dumps(found.get(name)):.200}"
            if name == "arithmetic":
                told += f", and this is {wanted[name]}"
            raise FesError(f"--out {directory}: it holds a sweep of {what}; {HEADER} has {name} = {told}")


def _lock(file: IO[bytes], directory: Path) -> None:
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise FesError(f"--out {directory}: another fes sweep is at work there") from None


def _read(file: IO[bytes], path: Path) -> dict[str, Done]:
    """The runs that have ended; what stands after the last whole line is cut off."""
    file.seek(0)
    done: dict[str, Done] = {}
    whole = number = 0
    while (line := file.readline(_MAX_LINE)).endswith(b"\n"):
        number, whole = number + 1, whole + len(line)
        one = _parse(line)
        if one is None:
            raise FesError(f"{path} is damaged: line {number} is not a run")
        done.setdefault(one.key, one)
    if len(line) == _MAX_LINE:
        raise FesError(f"{path} is damaged: line {number + 1} has more than {_MAX_LINE:,} bytes")
    file.truncate(whole)
    return done


def _line(one: Done) -> bytes:
    """The line of a run."""
    told = strict_json.dumps(asdict(one)).encode()
    return told[:-1] + b', "crc32": "%08x"}\n' % zlib.crc32(told)


def _parse(line: bytes) -> Done | None:
    """The run of a line; None if the line is not as it was written."""
    try:
        told = strict_json.loads(line)
        told.pop("crc32")
        one = Done(**told)
    except (ValueError, TypeError, KeyError, AttributeError):
        return None
    scalars = one.scalars.values() if isinstance(one.scalars, dict) else [one.scalars]
    plain = all(isinstance(value, str | int | float | bool | None) for value in (one.key, one.error, *scalars))
    return one if plain and _line(one) == line else None
