"""A run resumed from its last checkpoint: the inputs in the journal are executed again."""

import os
from collections import deque
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

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


class Resumed(NamedTuple):
    """A run at the tick at which its world ended."""

    run: Run
    checkpoints: CheckpointWriter
    elapsed: float
    """Wall-clock time since tick 0 [s]."""


def load(directory: Path) -> Snapshot:
    """The checkpoint of a run directory, with all its files checked; changes no file. Raises FesError."""
    if not checkpoint.has_checkpoint(directory):
        if not directory.exists():
            raise FesError(f"there is no run directory {directory}")
        raise FesError(f"{directory} has no checkpoint: its run is over, or wrote none")
    saved = snapshot.read(directory / FOLDER / STATE)
    try:
        saved.metrics.link_errors.digest.check_input(directory / FOLDER / DIGEST_INPUT)
        deque(_notes(directory, saved), maxlen=0)
        if saved.log is not None:
            _check_log(checkpoint.log_path(directory, saved.number), saved.log)
    except OSError as error:
        raise FesError(f"the checkpoint of {directory} cannot be read: {reason(error)}") from None
    except FesError:
        raise
    except Exception as error:  # impossible values may have a valid checksum
        raise FesError(f"{directory / FOLDER} is damaged: {type(error).__name__}") from None
    return saved


def _notes(directory: Path, saved: Snapshot) -> Iterator[tuple[int, list[Any]]]:
    """The notes since a checkpoint, each after the checksum of all notes so far."""
    return journal.chained(checkpoint.journals(directory, saved.number), saved.number, saved.checksum)


def _check_log(path: Path, log: LogPosition) -> None:
    """Raise FesError unless a log begins as the checkpoint recorded it, and OSError if it cannot be read."""
    deque(records.Reader(path, log.size), maxlen=0)  # its errors name the byte
    if files.sha256(path, log.size) != log.sha256:
        raise FesError(f"{path} is damaged: the SHA-256 of its first {log.size:,} bytes differs")


def recorder(directory: Path, saved: Snapshot) -> Recorder | None:
    """The log of the run, continued from the checkpoint; None if there was none. Raises FesError.

    If the log cannot be copied, the original stays in its place; else it stays until the next checkpoint records the
    copy.
    """
    if saved.log is None:
        return None
    path = directory / NAME
    try:
        before = checkpoint.set_log_aside(directory, saved.number)
    except OSError as error:
        raise FesError(f"the log of {directory} cannot be continued: {reason(error)}") from None
    try:
        return Recorder(path, saved.scenario, saved.name, "processes", (before, saved.log))
    except Exception as error:
        os.replace(before, path)
        why = reason(error) if isinstance(error, OSError) else error if isinstance(error, FesError) else repr(error)
        raise FesError(f"the log of {directory} cannot be continued: {why}") from None


def run(directory: Path, saved: Snapshot, recorder: Recorder | None, period: float) -> Resumed:
    """The run at the tick at which its world ended; `period` between its checkpoints from now on [s].

    Raises FesError. The journal holds every external input since the checkpoint; replaying it is deterministic.
    """
    checkpoints = CheckpointWriter(directory, period, saved.name, saved.run)
    checkpoints.hosts.update(saved.hosts)
    checkpoints.renewed.update(saved.renewed)
    try:
        run = Run(saved.scenario, recorder, checkpoints.note)
    except FesError:  # too little memory, a trace that has changed: not a fault of the checkpoint
        raise
    except Exception as error:
        raise FesError(f"{directory / FOLDER / STATE} is damaged: {type(error).__name__}") from None
    run.scenario, run.state, run.metrics = saved.changed_scenario, saved.state, saved.metrics
    run.excluded.update(saved.excluded)
    run.beacons.update(saved.beacons)
    elapsed, checksum = saved.elapsed, saved.checksum
    try:
        digest_input = run.metrics.link_errors.digest.resume_input(directory / FOLDER / DIGEST_INPUT)
        for after, note in _notes(directory, saved):
            checksum = after
            if note[0] == JOIN:
                checkpoints.note(note)
                checkpoints.hosts.update(dict.fromkeys(note[1], Join(tuple(note[1]), *note[2:])))
                run.readmit(note[1])
            else:
                elapsed = _replay(run, note, elapsed)
    except Exception as error:  # a note with a valid checksum may hold impossible values
        run.metrics.link_errors.digest.close()
        raise _refusal(directory, error) from None
    number = checkpoint.last_number(directory, saved.number)
    checkpoints.resume(run, digest_input, number, checksum, elapsed)
    return Resumed(run, checkpoints, elapsed)


def _refusal(directory: Path, error: Exception) -> FesError:
    """The FesError of a run that cannot be resumed because of `error`."""
    if isinstance(error, OSError):
        return FesError(f"cannot resume from the checkpoint of {directory}: {reason(error)}")
    if isinstance(error, FesError) and not isinstance(error, MessageError | ScenarioError):
        return error
    why = str(error) if isinstance(error, FesError | ValueError) else f"{type(error).__name__}: {error}"
    return FesError(f"the notes in {directory / FOLDER} are damaged: {' '.join(why.split())}")


def _replay(run: Run, note: list[Any], elapsed: float) -> float:
    """Execute a note, `elapsed` [s; wall clock] after tick 0; returns the time after it."""
    kind, tick, *rest = note
    if tick != run.state.tick:
        raise ValueError(f"a note of tick {tick} is at tick {run.state.tick}")
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
        tokens = np.frombuffer(alive, dtype=np.uint8)
        run.advance(run.observations(run.state.present), answers, beacons, tokens, elapsed)
        run.record_tick()
        return float(elapsed)
    else:
        raise ValueError(f"a note has the unknown kind {kind!r}")
    return elapsed
