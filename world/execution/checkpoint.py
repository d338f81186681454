"""Checkpoints: state from which a run resumes after its world dies, and the notes made since.

The folder `checkpoint` of a run directory holds

    state        the run at one tick (world.execution.snapshot); replaced as a whole
    journal-<k>  notes made since checkpoint k (world.execution.journal)
    trail        input of the digest so far (world.metrics.digest)
    log-<k>      the log as checkpoint k recorded it, while it is copied

Checkpoint k is written while the run continues and journal k is already in use. It replaces its predecessor in one
step, and the journals before k are then deleted. So the folder always holds a checkpoint and all
notes since.
"""

import contextlib
import logging
import os
import secrets
import shutil
import threading
import time
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any, BinaryIO

from fes.errors import FesError, reason
from fes.protocol.messages import Join
from fes.recording import hashed_file
from fes.recording.layout import NAME
from world.execution import snapshot
from world.execution.journal import Journal
from world.execution.run import TICK, Run
from world.execution.snapshot import Snapshot

FOLDER = "checkpoint"
STATE, DIGEST_INPUT = "state", "trail"

PERIOD = 10.0
"""Time between two checkpoints [s]."""

_logger = logging.getLogger("world")

JOIN = "join"
"""Kind of a note beside those of a run: [JOIN, robots, agent, arithmetic]; the agent hosts the robots from now on."""


class CheckpointWriter:
    """Writes the checkpoints of a run, and its notes, into its run directory.

    The run must have been created with the writer's `note`.
    """

    def __init__(self, directory: Path, period: float, name: str, run_name: str) -> None:
        """`period` between two checkpoints [s]; `name` of the scenario."""
        self._folder = directory / FOLDER
        self._period, self._name, self._run_name = period, name, run_name
        self._number = 0
        self._saved = time.monotonic()
        self._writing: Future[None] | None = None
        self._writer = ThreadPoolExecutor(1, "checkpoint")
        self._lock = threading.Lock()
        self._written = 0
        self._journal: Journal | None = None
        self._checksum = secrets.randbits(32)  # random, so that notes of another run never match
        self._digest_input: BinaryIO | None = None
        self._state: os.stat_result | None = None
        """Status of the file that was written last."""
        self.hosts: dict[int, Join] = {}
        """Robot -> the last Join that was accepted for it before the first checkpoint of this writer."""
        self.renewed: set[int] = set()
        """Robots whose agents have joined, but answered no tick yet."""

    def begin(self, run: Run) -> None:
        """Write the first checkpoint of a new run into a cleared run directory; raises FesError."""
        try:
            self._folder.mkdir()
            self._start(run, run.metrics.link_errors.digest.record_input(self._folder / DIGEST_INPUT), 0.0)
        except OSError as error:
            raise FesError(f"cannot write checkpoints: {reason(error)}") from None

    def resume(self, run: Run, digest_input: BinaryIO, number: int, checksum: int, elapsed: float) -> None:
        """Continue a resumed run after its checkpoint `number`, and after all notes that have this `checksum`."""
        self._number, self._checksum = number, checksum
        self._start(run, digest_input, elapsed)

    def _start(self, run: Run, digest_input: BinaryIO, elapsed: float) -> None:
        assert run.note == self.note, "a run whose notes go elsewhere could not be resumed"
        self._digest_input = digest_input
        self.save(run, self.hosts, elapsed, at_once=True)

    @property
    def due(self) -> bool:
        """True if it is time for another checkpoint."""
        busy = self._writing is not None and not self._writing.done()
        return not busy and time.monotonic() - self._saved >= self._period

    def note(self, note: list[Any]) -> None:
        """Append a note to the journal; there is no journal before the first checkpoint and after `close`."""
        update_renewed(self.renewed, note)
        if self._journal is not None:
            self._journal.add(note)

    def check(self) -> None:
        """Raise the FesError that stopped the journal, if a note could not be written."""
        if self._journal is not None and self._journal.failure is not None:
            raise self._journal.failure

    def save(self, run: Run, hosts: dict[int, Join], elapsed: float, *, at_once: bool = False) -> None:
        """Write a checkpoint of a run between two ticks, in the background or `at_once`; raises FesError."""
        if self._writing is not None and self._writing.done():
            self._writing.result()
        self.check()
        assert self._digest_input is not None
        loss = self._loss_of_digest_input(run)
        if loss is not None:
            raise FesError(f"cannot write a checkpoint: {loss}")
        before = self._journal
        checksum = self._checksum if before is None else before.checksum
        self._number += 1
        self._saved = time.monotonic()
        state = Snapshot(
            number=self._number,
            name=self._name,
            run=self._run_name,
            scenario=run.world.scenario,
            changed_scenario=run.scenario,
            state=run.state,
            metrics=run.metrics,
            hosts=dict(hosts),
            renewed=sorted(self.renewed),
            excluded=dict(run.excluded),
            beacons=dict(run.beacons),
            log=run.recorder.pause() if run.recorder is not None else None,
            elapsed=elapsed,
            checksum=checksum,
        )
        content = snapshot.pack(state)
        self._journal = Journal(self._folder / f"journal-{self._number}", self._number, checksum)
        if before is not None:
            before.close()
        files = [self._digest_input.fileno()] + ([run.recorder.fileno] if run.recorder is not None else [])
        if at_once:
            self._write(self._number, content, files)
        else:
            self._writing = self._writer.submit(self._write, self._number, content, files)

    def losses(self, run: Run) -> list[str]:
        """One text per file of the current checkpoint that another program removed or cut."""
        journal, state, path = self._journal, self._state, self._folder / STATE
        if journal is None or journal.failure is not None:
            return []
        losses = [self._loss_of_digest_input(run), (loss := journal.loss()) and f"{journal.path} {loss}"]
        if state is not None and not (path.exists() and os.path.samestat(path.stat(), state)):
            losses.append(f"{path} was removed or replaced")
        return [loss for loss in losses if loss is not None]

    def close(self, run: Run) -> None:
        """Write no more checkpoints and notes."""
        with contextlib.suppress(OSError), self._lock:
            for loss in self.losses(run):
                _logger.warning("%s during the run: from then on the run could not have been resumed", loss)
        self._writer.shutdown(wait=False, cancel_futures=True)
        with self._lock:
            self._written = self._number + 1  # so that a write in progress has no effect
            run.metrics.link_errors.digest.close()
            if self._journal is not None:
                self._journal.close()
                self._journal = None

    def discard(self, run: Run) -> None:
        """Close, and delete the checkpoint: the run is over."""
        self.close(run)
        clear(self._folder.parent)

    def _loss_of_digest_input(self, run: Run) -> str | None:
        assert self._digest_input is not None
        self._digest_input.flush()
        path = self._folder / DIGEST_INPUT
        loss = hashed_file.loss(path, self._digest_input.fileno(), run.metrics.link_errors.digest.length)
        return loss and f"{path} {loss}"

    def _write(self, number: int, content: bytes, files: list[int]) -> None:
        with self._lock:
            if number < self._written:
                return  # a later checkpoint was written first
            self._written = number
            try:
                for fileno in files:
                    os.fsync(fileno)
                part = self._folder / f".{STATE}"
                with part.open("wb") as file:
                    file.write(content)
                    file.flush()
                    os.fsync(file.fileno())
                    written = os.fstat(file.fileno())
                os.replace(part, self._folder / STATE)
                self._state = written
            except OSError as error:
                raise FesError(f"cannot write a checkpoint: {reason(error)}") from None
            for old in [*self._folder.glob("journal-*"), *self._folder.glob("log-*")]:
                if _number(old) < number:
                    old.unlink(missing_ok=True)


def clear(directory: Path) -> None:
    """Delete the checkpoint of a run directory."""
    # The state first: without its journals it would resume an older tick.
    (directory / FOLDER / STATE).unlink(missing_ok=True)
    shutil.rmtree(directory / FOLDER, ignore_errors=True)


def has_checkpoint(directory: Path) -> bool:
    """True if a run directory has a checkpoint: its run is not over."""
    return (directory / FOLDER / STATE).exists()


def update_renewed(renewed: set[int], note: list[Any]) -> None:
    """Update the robots whose agents have joined, but answered no tick yet, by a note."""
    if note[0] == JOIN:
        renewed.update(note[1])
    elif note[0] == TICK and renewed:
        renewed.difference_update([robot for robot, command in enumerate(note[2]) if command])


def journals(directory: Path, number: int) -> list[Path]:
    """The journals of a run directory that belong to its checkpoint `number`, in order."""
    paths = sorted((directory / FOLDER).glob("journal-*"), key=_number)
    return [path for path in paths if _number(path) >= number]


def last_number(directory: Path, number: int) -> int:
    """The number of the last checkpoint that was begun after checkpoint `number`, or of this one."""
    return max([number, *map(_number, journals(directory, number))])


def log_path(directory: Path, number: int) -> Path:
    """Path of the log as checkpoint `number` recorded it."""
    aside = directory / FOLDER / f"log-{number}"
    return aside if aside.exists() else directory / NAME


def set_log_aside(directory: Path, number: int) -> Path:
    """Move the log as checkpoint `number` recorded it to a path that is not written; raises OSError."""
    path, aside = log_path(directory, number), directory / FOLDER / f"log-{number}"
    if path != aside:
        os.replace(path, aside)
    return aside


def _number(path: Path) -> int:
    text = path.name.rpartition("-")[2]
    return int(text) if text.isascii() and text.isdigit() else -1
