"""A run gone on with from its last checkpoint: what has happened since is gone through again."""

import os
from collections import deque
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from fes.errors import FesError, MessageError, ScenarioError, reason
from fes.protocol import messages
from fes.protocol.messages import Join
from fes.recording import records
from fes.recording.layout import NAME
from fes.system import files
from world.execution import checkpoint, journal, snapshot
from world.execution.checkpoint import DIGEST_INPUT, FOLDER, JOIN, STATE, CheckpointWriter
from world.execution.recorder import LogPosition, Recorder
from world.execution.run import ATTEND, EXCLUDE, SET, TICK, Run
from world.execution.snapshot import Snapshot


def load(directory: Path) -> Snapshot:
    """The checkpoint of a run directory, if all its files are whole; raises FesError if not. It changes no file."""
    if not checkpoint.has_checkpoint(directory):
        if not directory.exists():
            raise FesError(f"there is no run directory {directory}")
        raise FesError(f"{directory} has no checkpoint: its run is over, or kept none")
    kept = snapshot.read(directory / FOLDER / STATE)
    try:
        kept.metrics.link_errors.digest.check_input(directory / FOLDER / DIGEST_INPUT)
        deque(_notes(directory, kept), maxlen=0)
        if kept.log is not None:
            _check_log(checkpoint.log_of(directory, kept.number), kept.log)
    except OSError as error:
        raise FesError(f"the checkpoint of {directory} cannot be read: {reason(error)}") from None
    except FesError:
        raise
    except Exception as error:  # checksums may be valid, and values impossible
        raise FesError(f"{directory / FOLDER} is damaged: {type(error).__name__}") from None
    return kept


def _notes(directory: Path, kept: Snapshot) -> Iterator[tuple[int, list[Any]]]:
    """The notes since a checkpoint, each after the checksum of all notes so far."""
    return journal.chained(checkpoint.journals(directory, kept.number), kept.number, kept.notes)


def _check_log(path: Path, log: LogPosition) -> None:
    """Raise FesError unless a log begins as the checkpoint knew it, and OSError if it cannot be read."""
    deque(records.Reader(path, log.size), maxlen=0)  # its errors name the place
    if files.sha256(path, log.size) != log.sha256:
        raise FesError(f"{path} is damaged: the SHA-256 of its first {log.size:,} bytes differs")


def recorder(directory: Path, kept: Snapshot) -> Recorder | None:
    """The log of the run, continued from the checkpoint; None if there was none. Raises FesError.

    If it cannot be copied, the original stays in its place; else it is kept until the next checkpoint knows the copy.
    """
    if kept.log is None:
        return None
    path = directory / NAME
    try:
        before = checkpoint.set_log_aside(directory, kept.number)
    except OSError as error:
        raise FesError(f"the log of {directory} cannot be continued: {reason(error)}") from None
    try:
        return Recorder(path, kept.scenario, kept.name, "processes", (before, kept.log))
    except Exception as error:
        os.replace(before, path)  # as it was before
        why = reason(error) if isinstance(error, OSError) else error if isinstance(error, FesError) else repr(error)
        raise FesError(f"the log of {directory} cannot be continued: {why}") from None


def run(
    directory: Path, kept: Snapshot, recorder: Recorder | None, period: float
) -> tuple[Run, CheckpointWriter, float]:
    """The run as it was when its world ended, who keeps it from now on, and the time since tick 0 [s].

    Raises FesError. Since the checkpoint it has been noted what came from outside: the rest is a function of that.
    """
    try:
        run = Run(kept.scenario, recorder)
    except ScenarioError:  # such as too little memory: no fault of the checkpoint
        raise
    except Exception as error:
        raise FesError(f"{directory / FOLDER / STATE} is damaged: {type(error).__name__}") from None
    run.scenario, run.state, run.metrics = kept.now, kept.state, kept.metrics
    run.excluded.update(kept.excluded)
    run.beacons.update(kept.beacons)
    hosts, renewed, elapsed = dict(kept.hosts), set(kept.renewed), kept.elapsed
    notes = kept.notes
    try:
        trail = run.metrics.link_errors.digest.resume_input(directory / FOLDER / DIGEST_INPUT)
        for after, note in _notes(directory, kept):
            notes = after
            checkpoint.renew(renewed, note)
            if note[0] == JOIN:
                hosts.update(dict.fromkeys(note[1], Join(tuple(note[1]), *note[2:])))
                run.readmit(note[1])
            else:
                elapsed = _again(run, note, elapsed)
    except Exception as error:  # a note with a valid checksum may hold impossible values
        run.metrics.link_errors.digest.close()
        raise _refusal(directory, error) from None
    number = checkpoint.last(directory, kept.number)
    checkpoints = CheckpointWriter(directory, period, kept.name, kept.run, number=number, notes=notes)
    checkpoints.follow(run, trail, hosts, renewed, elapsed)
    return run, checkpoints, elapsed


def _refusal(directory: Path, error: Exception) -> FesError:
    """The error of a run that cannot be resumed, for whatever `error` occurred on the way."""
    if isinstance(error, OSError):
        return FesError(f"cannot resume from the checkpoint of {directory}: {reason(error)}")
    if isinstance(error, FesError) and not isinstance(error, MessageError | ScenarioError):
        return error
    why = str(error) if isinstance(error, FesError | ValueError) else f"{type(error).__name__}: {error}"
    return FesError(f"the notes in {directory / FOLDER} are damaged: {' '.join(why.split())}")


def _again(run: Run, note: list[Any], elapsed: float) -> float:
    """Go through what was noted, `elapsed` [s; wall clock] after tick 0; returns how long after it then is."""
    kind, tick, *rest = note
    if tick != run.state.tick:
        raise ValueError(f"a note of tick {tick} stands at tick {run.state.tick}")
    if kind == ATTEND:
        run.attend(np.isin(run.world.ids, rest[0]))
    elif kind == EXCLUDE:
        run.exclude(*rest)
    elif kind == SET:
        path, value = rest
        run.change(path, value, replayed=True)
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
