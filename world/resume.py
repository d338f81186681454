"""A run gone on with from its last checkpoint: what has happened since is gone through again."""

import io
import pickle
from dataclasses import is_dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import BaseModel

from fes import messages
from fes.distribution import version
from fes.errors import FesError, MessageError, ScenarioError, reason
from fes.messages import Join
from world import checkpoint, journal
from world.account import Account
from world.breathing import Breathing
from world.checkpoint import FOLDER, JOIN, MAGIC, STATE, TRAIL, Keeper, Snapshot
from world.course import ATTEND, EXCLUDE, SET, TICK, Course
from world.digest import Digest
from world.recorder import NAME, Recorder
from world.tracking import Tracking

_PLAIN = (Account, Breathing, Digest, Tracking)
_OTHERS = {
    ("collections", "deque"),
    ("numpy", "dtype"),
    ("numpy", "ndarray"),
    ("numpy._core.multiarray", "_reconstruct"),
    ("numpy._core.multiarray", "scalar"),
    ("numpy._core.numeric", "_frombuffer"),
}
"""What a checkpoint may be made of beside the world's own tables: nothing in it can run anything else."""


def load(directory: Path) -> Snapshot:
    """The checkpoint of a run directory; raises FesError."""
    path = directory / FOLDER / STATE
    try:
        magic, ours, told = path.read_bytes().split(b"\n", 2)
    except FileNotFoundError:
        if not directory.exists():
            raise FesError(f"there is no run directory {directory}") from None
        raise FesError(f"{directory} has no checkpoint: its run is over, or kept none") from None
    except OSError as error:
        raise FesError(f"{path} cannot be read: {reason(error)}") from None
    except ValueError:
        raise FesError(f"{path} is not a checkpoint") from None
    if magic != MAGIC:
        raise FesError(f"{path} is not a checkpoint that this fes can read")
    if ours.decode(errors="replace") != version():
        raise FesError(f"{path} was kept by fes {ours.decode(errors='replace')[:20]}, this is {version()}")
    try:
        snapshot = _Tables(io.BytesIO(told)).load()
    except Exception as error:
        raise FesError(f"{path} is damaged: {type(error).__name__}") from None
    if not isinstance(snapshot, Snapshot):
        raise FesError(f"{path} is not a checkpoint")
    return snapshot


def recorder(directory: Path, snapshot: Snapshot) -> Recorder | None:
    """The log of the run, to be gone on with from the checkpoint; None if there was none. Raises FesError."""
    if snapshot.log is None:
        return None
    try:
        before = checkpoint.set_log_aside(directory, snapshot.number)
        return Recorder(directory / NAME, snapshot.scenario, snapshot.name, "processes", (before, snapshot.log))
    except (OSError, FesError) as error:
        raise FesError(
            f"the log of {directory} cannot be gone on with: {reason(error) if isinstance(error, OSError) else error}"
        ) from None


def course(
    directory: Path, snapshot: Snapshot, recorder: Recorder | None, period: float
) -> tuple[Course, Keeper, float]:
    """The run as it was when its world ended, who keeps it from now on, and the time since tick 0 [s].

    Raises FesError. Since the checkpoint it has been noted what came from outside: the rest is a function of that.
    """
    run = Course(snapshot.scenario, recorder)
    run.scenario, run.state, run.sums = snapshot.now, snapshot.state, snapshot.sums
    run.excluded.update(snapshot.excluded)
    run.beacons.update(snapshot.beacons)
    hosts, renewed, elapsed = dict(snapshot.hosts), set(snapshot.renewed), snapshot.elapsed
    try:
        trail = run.sums.tally.digest.take_up(directory / FOLDER / TRAIL)
        for path in checkpoint.journals(directory, snapshot.number):
            for note in journal.notes(path):
                checkpoint.renew(renewed, note)
                if note[0] == JOIN:
                    hosts.update(dict.fromkeys(note[1], Join(tuple(note[1]), note[2])))
                    run.readmit(note[1])
                else:
                    elapsed = _again(run, note, elapsed)
    except (OSError, EOFError) as error:
        run.sums.tally.digest.close()
        raise FesError(f"the checkpoint of {directory} cannot be gone on from: {error}") from None
    except (MessageError, ScenarioError, ValueError, TypeError, IndexError) as error:
        run.sums.tally.digest.close()
        raise FesError(f"the notes in {directory / FOLDER} are damaged: {error}") from None
    number = checkpoint.last(directory, snapshot.number)
    keeper = Keeper(directory, period, snapshot.name, snapshot.run, number=number)
    keeper.follow(run, trail, hosts, renewed, elapsed)
    return run, keeper, elapsed


def _again(run: Course, note: list[Any], elapsed: float) -> float:
    """Go through what was noted, `elapsed` [s; wall clock] after tick 0; returns how long after it then is."""
    kind, tick, *rest = note
    if tick != run.state.tick:
        raise ValueError(f"a note of tick {tick} stands at tick {run.state.tick}")
    if kind == ATTEND:
        run.attend(np.isin(run.world.ids, rest[0]))
    elif kind == EXCLUDE:
        run.exclude(*rest)
    elif kind == SET:
        run.change(*rest)
    elif kind == TICK:
        commands, beacons, alive, elapsed = rest
        answers = [(messages.decode_command(payload), payload) if payload else None for payload in commands]
        seen = np.frombuffer(alive, dtype=np.uint8)
        run.take(run.observations(run.state.present), answers, beacons, seen, elapsed)
        run.account()
        return float(elapsed)
    else:
        raise ValueError(f"a note of kind {kind!r}")
    return elapsed


class _Tables(pickle.Unpickler):
    """Reads arrays and the world's own tables, and nothing else."""

    def find_class(self, module: str, name: str) -> Any:
        other = (module, name) in _OTHERS
        if "." in name or not (other or module.split(".")[0] in ("fes", "world")):  # before it is imported, and runs
            raise pickle.UnpicklingError(f"{module}.{name}")
        found = super().find_class(module, name)
        ours = isinstance(found, type) and found.__module__ == module
        if other or (ours and (is_dataclass(found) or issubclass(found, (BaseModel, tuple)) or found in _PLAIN)):
            return found
        raise pickle.UnpicklingError(f"{module}.{name}")
