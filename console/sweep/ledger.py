"""Finished runs, durable through every interruption: one line per run, appended at its end.

A line cut short by a kill is dropped, and its run is repeated. Each run has one line, found by its key. Each line
ends with a checksum of the text before it. All runs of a directory are computed with one arithmetic,
and with one source of each extension.
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
from world.config.outside import extensions

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
    "extensions": "another source of its extensions",
}


@dataclass(eq=False)
class Ledger:
    """An open ledger."""

    done: dict[str, Done]
    """Finished runs by key."""
    _file: IO[bytes]

    def add(self, ended: Sequence[Done]) -> None:
        """Write the results of these runs to the disk."""
        fresh = {run.key: run for run in ended if run.key not in self.done}
        self._file.write(b"".join(map(_line, fresh.values())))
        self._file.flush()
        os.fsync(self._file.fileno())
        self.done |= fresh

    def read_again(self) -> None:
        """Read the finished runs from the disk, after a signal that may have interrupted a write."""
        self._file.flush()
        self.done = _read(self._file, Path(self._file.name))


def default_directory(design: Design) -> Path:
    """The directory in which a repeated command finds its sweep."""
    return Path("sweeps") / f"{encoding.file_name(design.name)}-{_identity(design)['cells'][:8]}"


@contextlib.contextmanager
def opened(directory: Path, design: Design) -> Iterator[Ledger]:
    """The ledger of a design in a directory, created or resumed; raises FesError if it is of another design."""
    with contextlib.ExitStack() as stack:
        try:
            directory.mkdir(parents=True, exist_ok=True)
            _check_header(directory, design)
            file = stack.enter_context((directory / LINES).open("a+b"))
            _lock(file, directory)
            done = _read(file, directory / LINES)
        except OSError as error:
            raise FesError(f"cannot store a sweep: {reason(error)}") from None
        yield Ledger(done, file)


def _identity(design: Design) -> dict[str, Any]:
    """Header of a directory: equal for designs that differ only in their seeds."""
    cells = "".join(digest(seeded(cell.scenario, 0)) for cell in design.cells)
    evidence = dict.fromkeys(entry for cell in design.cells for entry in extensions.of(cell.scenario))
    axes = {field: design.values(index) for index, field in enumerate(design.axes)}
    return {
        "scenario": design.name,
        "axes": axes,
        "cells": hashlib.sha256(cells.encode()).hexdigest(),
        "fes": version(),
        "arithmetic": fingerprint.table()["fingerprint"],
        "extensions": [entry.table for entry in evidence],
        "format": FORMAT,
    }


def _check_header(directory: Path, design: Design) -> None:
    """Write the directory's header, or check that it is of this design; raises FesError."""
    path, identity = directory / HEADER, _identity(design)
    if not path.exists():
        temporary = directory / f".{HEADER}"
        if any(path != temporary for path in directory.iterdir()):  # a kill may leave a temporary file
            raise FesError(f"--out {directory}: the directory is not empty, and holds no sweep")
        temporary.write_text(strict_json.dumps(identity, indent=1) + "\n", encoding="utf-8")
        os.replace(temporary, path)
        return
    header = files.read_table(path, _MAX_HEADER)
    before = header.get("format", 1)
    if before != FORMAT:
        raise FesError(
            f"--out {directory}: it holds a sweep of format {before!r:.20}; this fes reads format {FORMAT}"
        )
    for name, difference in _DIFFERS.items():
        if header.get(name) != identity[name]:
            recorded = f"{strict_json.dumps(header.get(name)):.200}"
            if name in ("fes", "arithmetic"):
                recorded += f", and this is {strict_json.dumps(identity[name])}"
            raise FesError(f"--out {directory}: it holds a sweep of {difference}; {HEADER} has {name} = {recorded}")


def _lock(file: IO[bytes], directory: Path) -> None:
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise FesError(f"--out {directory}: another fes sweep is using it") from None


def _read(file: IO[bytes], path: Path) -> dict[str, Done]:
    """The finished runs; an incomplete last line is cut off."""
    file.seek(0)
    done: dict[str, Done] = {}
    complete = number = 0
    while (line := file.readline(_MAX_LINE)).endswith(b"\n"):
        number, complete = number + 1, complete + len(line)
        run = _parse(line)
        if run is None:
            raise FesError(f"{path} is damaged: line {number} is not a run")
        done.setdefault(run.key, run)
    if len(line) == _MAX_LINE:
        raise FesError(f"{path} is damaged: line {number + 1} has more than {_MAX_LINE:,} bytes")
    file.truncate(complete)
    return done


def _line(run: Done) -> bytes:
    """Encode a run as a line."""
    text = strict_json.dumps(asdict(run)).encode()
    return text[:-1] + b', "crc32": "%08x"}\n' % zlib.crc32(text)


def _parse(line: bytes) -> Done | None:
    """Decode the run of a line; None if the line is damaged."""
    try:
        fields = strict_json.loads(line)
        fields.pop("crc32")
        run = Done(**fields)
    except (ValueError, TypeError, KeyError, AttributeError):
        return None
    scalars = run.scalars.values() if isinstance(run.scalars, dict) else [run.scalars]
    is_plain = all(isinstance(value, str | int | float | bool | None) for value in (run.key, run.error, *scalars))
    return run if is_plain and _line(run) == line else None
