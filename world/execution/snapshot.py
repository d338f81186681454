"""A run at one tick, and the file `state` that holds it: a head of three lines, and the run's tables as a pickle.

    fes checkpoint 3
    SHA-256 of all that follows
    {"fes": "0.2.0", "arithmetic": {"fingerprint": ..., "numpy": ..., "core": ...}}

A state is read only if all of this matches. Loading it cannot execute code.
"""

import hashlib
import io
import pickle
import pickletools
import re
from dataclasses import dataclass, is_dataclass
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from fes.errors import FesError, reason
from fes.protocol import world_info
from fes.protocol.messages import Join
from fes.system import files, fingerprint, strict_json
from world.config.scenario import Scenario
from world.execution.recorder import LogPosition
from world.metrics.collector import MetricsCollector
from world.metrics.digest import Digest
from world.metrics.period_average import PeriodAverage
from world.metrics.tracking import Tracking
from world.simulation.truth import State

FORMAT = 3
"""Format of a checkpoint, its journals and its trail: raise it when one of them, or a table of the run, changes."""

LARGEST = 1 << 30
"""Largest state that is read [bytes]; that of a hundred robots has 200 kB."""

_FIRST = re.compile(rb"fes checkpoint (\d{1,9})")

_PLAIN = (MetricsCollector, PeriodAverage, Digest, Tracking)
_OTHERS = {
    ("collections", "deque"),
    ("numpy", "dtype"),
    ("numpy", "ndarray"),
    ("numpy._core.multiarray", "_reconstruct"),
    ("numpy._core.multiarray", "scalar"),
    ("numpy._core.numeric", "_frombuffer"),
}
"""Names that a checkpoint may hold beside the world's own tables: loading them cannot execute code."""

_PLACED = {"PUT", "BINPUT", "LONG_BINPUT"}
"""Opcodes that our pickles never have: a few bytes of them would claim all memory."""


@dataclass(frozen=True, eq=False)
class Snapshot:
    """A run at one tick."""

    number: int
    """Number of the checkpoint within the run."""
    name: str
    """Name of the scenario."""
    run: str
    scenario: Scenario
    """The scenario with which the run began."""
    now: Scenario
    """The scenario with all that persons have set since."""
    state: State
    metrics: MetricsCollector
    hosts: dict[int, Join]
    """The last Join that was accepted for each robot."""
    renewed: list[int]
    """Robots whose agents have joined, but answered no tick yet."""
    excluded: dict[int, str]
    """Robots that are excluded, and why."""
    beacons: dict[int, list[bytes]]
    """Tick -> the Beacons that peers may still ask for, by robot."""
    log: LogPosition | None
    elapsed: float
    """Wall-clock time since tick 0 [s]."""
    notes: int
    """Checksum of all notes so far."""


_KINDS: dict[str, Any] = {
    **dict.fromkeys(("number", "notes"), int),
    **dict.fromkeys(("name", "run"), str),
    **dict.fromkeys(("scenario", "now"), Scenario),
    "state": State,
    "metrics": MetricsCollector,
    "hosts": dict,
    "renewed": list,
    "excluded": dict,
    "beacons": dict,
    "log": LogPosition | None,
    "elapsed": float,
}
"""Types of its fields."""


def pack(snapshot: Snapshot) -> bytes:
    """The content of the file of a snapshot."""
    head = {"fes": world_info.version(), "arithmetic": fingerprint.table()}
    told = strict_json.dumps(head).encode() + b"\n" + pickle.dumps(snapshot, protocol=5)
    return b"\n".join([b"fes checkpoint %d" % FORMAT, hashlib.sha256(told).hexdigest().encode(), told])


def read(path: Path) -> Snapshot:
    """The snapshot in a file; raises FesError in one line, also where nothing but a checksum is wrong."""
    try:
        first, _, rest = files.read(path, LARGEST).partition(b"\n")
    except OSError as error:
        raise FesError(f"{path} cannot be read: {reason(error)}") from None
    found = _FIRST.fullmatch(first)
    if found is None:
        raise FesError(f"{path} is not a checkpoint")
    if int(found[1]) != FORMAT:
        raise FesError(f"{path} is a checkpoint of format {int(found[1])}; this fes reads format {FORMAT}")
    checksum, _, told = rest.partition(b"\n")
    if checksum != hashlib.sha256(told).hexdigest().encode():
        raise FesError(f"{path} is damaged: its SHA-256 differs")
    head, _, pickled = told.partition(b"\n")
    _check_arithmetic(path, head)
    try:
        for opcode, _, _ in pickletools.genops(pickled):
            if opcode.name in _PLACED:
                raise pickle.UnpicklingError(opcode.name)
        snapshot = _Tables(io.BytesIO(pickled)).load()
    except Exception as error:
        raise FesError(f"{path} is damaged: {type(error).__name__}") from None
    if not isinstance(snapshot, Snapshot) or not all(
        isinstance(getattr(snapshot, name, None), kind) for name, kind in _KINDS.items()
    ):
        raise FesError(f"{path} is not a checkpoint")
    return snapshot


def _check_arithmetic(path: Path, head: bytes) -> None:
    """Raise FesError unless the run was computed with this process's arithmetic."""
    try:
        theirs = fingerprint.text(strict_json.loads(head)["arithmetic"])
    except (ValueError, KeyError, TypeError) as error:
        raise FesError(f"{path} is damaged: its head cannot be read: {type(error).__name__}") from None
    if theirs != fingerprint.text():
        raise FesError(f"{path} was kept with {theirs}; this is {fingerprint.text()}: the digits would differ")


class _Tables(pickle.Unpickler):
    """Reads arrays and the world's own tables, and nothing else."""

    def find_class(self, module: str, name: str) -> Any:
        other = (module, name) in _OTHERS
        if "." in name or not (other or module.split(".")[0] in ("fes", "world")):  # before the import runs code
            raise pickle.UnpicklingError(f"{module}.{name}")
        found = super().find_class(module, name)
        ours = isinstance(found, type) and found.__module__ == module
        if other or (ours and (is_dataclass(found) or issubclass(found, (BaseModel, tuple)) or found in _PLAIN)):
            return found
        raise pickle.UnpicklingError(f"{module}.{name}")
