"""Snapshot of a run at one tick, and its file `state`: a head of three lines, and the run's tables as a pickle.

    fes checkpoint 7
    SHA-256 of the rest of the file
    {"fes": "0.9.0", "arithmetic": {"fingerprint": ..., "numpy": ..., "core": ...}, "extensions": [...]}

A state is read only if its format, checksum, arithmetic and extensions match. Loading it cannot execute code.
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
from fes.extension import registry
from fes.extension.checked import CheckedMetric
from fes.extension.kinds import DYNAMICS, METRIC
from fes.model.table import chosen
from fes.protocol import world_info
from fes.protocol.messages import Join
from fes.system import files, fingerprint, strict_json
from world.config.outside import extensions
from world.config.scenario import Scenario
from world.execution.recorder import LogPosition
from world.metrics.collector import MetricsCollector
from world.metrics.digest import Digest
from world.metrics.period_average import PeriodAverage
from world.metrics.tracking import Tracking
from world.simulation.truth import State

FORMAT = 7
"""Format of a checkpoint, its journals and its trail. Raise it when one of them, or a table of the run, changes."""

LARGEST = 1 << 30
"""Largest state that is read [bytes]; the state of a hundred robots has 200 kB."""

_FIRST = re.compile(rb"fes checkpoint (\d{1,9})")

_PLAIN = (MetricsCollector, PeriodAverage, Digest, Tracking, CheckedMetric)
_FOREIGN = {
    ("collections", "deque"),
    ("numpy", "dtype"),
    ("numpy", "ndarray"),
    ("numpy._core.multiarray", "_reconstruct"),
    ("numpy._core.multiarray", "scalar"),
    ("numpy._core.numeric", "_frombuffer"),
}
"""Names that a checkpoint may hold beside the world's own tables: loading them cannot execute code."""

_FORBIDDEN = {"PUT", "BINPUT", "LONG_BINPUT"}
"""Opcodes that the project's pickles never have: a few bytes with them could claim all memory."""


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
    changed_scenario: Scenario
    """The scenario with all changes by persons since."""
    state: State
    metrics: MetricsCollector
    hosts: dict[int, Join]
    """Robot -> the last Join that was accepted for it."""
    renewed: list[int]
    """Robots whose agents have joined, but answered no tick yet."""
    excluded: dict[int, str]
    """Robot -> its fault."""
    beacons: dict[int, list[bytes]]
    """Tick -> the Beacons that peers may still recall, by robot."""
    log: LogPosition | None
    elapsed: float
    """Wall-clock time since tick 0 [s]."""
    checksum: int
    """Checksum of all notes so far."""


_KINDS: dict[str, Any] = {
    **dict.fromkeys(("number", "checksum"), int),
    **dict.fromkeys(("name", "run"), str),
    **dict.fromkeys(("scenario", "changed_scenario"), Scenario),
    "state": State,
    "metrics": MetricsCollector,
    "hosts": dict,
    "renewed": list,
    "excluded": dict,
    "beacons": dict,
    "log": LogPosition | None,
    "elapsed": float,
}
"""Types of the fields of a Snapshot."""


def pack(snapshot: Snapshot) -> bytes:
    """The content of the file of a snapshot; raises FesError if the state of an extension cannot be in it."""
    _check_extensions(snapshot)
    evidence = [entry.table for entry in extensions.of(snapshot.scenario)]
    head = {"fes": world_info.version(), "arithmetic": fingerprint.table(), "extensions": evidence}
    body = strict_json.dumps(head).encode() + b"\n" + pickle.dumps(snapshot, protocol=5)
    return b"\n".join([b"fes checkpoint %d" % FORMAT, hashlib.sha256(body).hexdigest().encode(), body])


def _check_extensions(snapshot: Snapshot) -> None:
    """Raise FesError unless the states of all extensions can be pickled, and read again."""
    dynamics = chosen(snapshot.scenario.robots.dynamics).use
    bodies = [(DYNAMICS, dynamics, snapshot.state.bodies)] if dynamics not in DYNAMICS.built_in else []
    metrics = [(METRIC, metric.use, snapshot.metrics.extensions[metric.key]) for metric in snapshot.scenario.metric]
    for kind, name, state in bodies + metrics:
        try:
            _Tables(io.BytesIO(pickle.dumps(state, protocol=5))).load()
        except Exception as error:  # the state is that of anybody's code
            raise FesError(
                f"{kind.name} '{name}': its state cannot be in a checkpoint: {type(error).__name__}: {error}"
            ) from None


def read(path: Path) -> Snapshot:
    """The snapshot in a file; raises FesError in one line, also if only a checksum is wrong."""
    try:
        first, _, rest = files.read(path, LARGEST).partition(b"\n")
    except OSError as error:
        raise FesError(f"{path} cannot be read: {reason(error, with_file=False)}") from None
    match = _FIRST.fullmatch(first)
    if match is None:
        raise FesError(f"{path} is not a checkpoint")
    if int(match[1]) != FORMAT:
        raise FesError(f"{path} is a checkpoint of format {int(match[1])}; this fes reads format {FORMAT}")
    checksum, _, body = rest.partition(b"\n")
    if checksum != hashlib.sha256(body).hexdigest().encode():
        raise FesError(f"{path} is damaged: its SHA-256 differs")
    head, _, pickled = body.partition(b"\n")
    _check_arithmetic(path, head)
    recorded = strict_json.loads(head).get("extensions", [])
    extensions.check_recorded(recorded, str(path))
    try:
        for opcode, _, _ in pickletools.genops(pickled):
            if opcode.name in _FORBIDDEN:
                raise pickle.UnpicklingError(opcode.name)
        snapshot = _Tables(io.BytesIO(pickled)).load()
    except Exception as error:
        raise FesError(f"{path} is damaged: {type(error).__name__}") from None
    if not isinstance(snapshot, Snapshot) or not all(
        isinstance(getattr(snapshot, name, None), kind) for name, kind in _KINDS.items()
    ):
        raise FesError(f"{path} is not a checkpoint")
    extensions.check(snapshot.scenario, recorded, str(path))
    return snapshot


def _check_arithmetic(path: Path, head: bytes) -> None:
    """Raise FesError unless the run was computed with this process's arithmetic."""
    try:
        table = strict_json.loads(head)
        arithmetic = table["arithmetic"]
        is_same = fingerprint.text(arithmetic) == fingerprint.text()
        origin = fingerprint.origin(table.get("fes"), arithmetic)
    except (ValueError, KeyError, TypeError) as error:
        raise FesError(f"{path} is damaged: its head cannot be read: {type(error).__name__}") from None
    if not is_same:
        own = fingerprint.origin(world_info.version())
        raise FesError(f"{path} was written by {origin}; this is {own}: the digits would differ")


class _Tables(pickle.Unpickler):
    """Reads only arrays and the world's own tables."""

    def find_class(self, module: str, name: str) -> Any:
        is_foreign, is_extension = (module, name) in _FOREIGN, registry.is_usable(module)
        is_known = is_foreign or is_extension or module.split(".")[0] in ("fes", "world")
        is_nested = "." in name  # such as the `Parameters` of a metric
        if not is_known or (is_nested and not is_extension):  # before the import runs code
            raise pickle.UnpicklingError(f"{module}.{name}")
        kind = super().find_class(module, name)
        is_own = isinstance(kind, type) and (kind.__module__, kind.__qualname__) == (module, name)
        is_extension = is_extension or f"{module}:{name}" in METRIC.built_in.values()
        if is_extension and is_own:
            return kind
        if is_foreign or (is_own and (is_dataclass(kind) or issubclass(kind, (BaseModel, tuple)) or kind in _PLAIN)):
            return kind
        raise pickle.UnpicklingError(f"{module}.{name}")
