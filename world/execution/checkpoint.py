"""What a run can be gone on from if its world dies: a checkpoint, and the notes made since.

The folder `checkpoint` of a run directory holds

    state        the run at one tick (world.execution.snapshot): complete, or the one before it
    journal-<k>  notes made since checkpoint k (world.execution.journal)
    trail        what went into the digest until then (world.metrics.digest)
    log-<k>      the log as checkpoint k knew it, while it is copied

Checkpoint k is written beside the run while journal k is already in use, and replaces its predecessor in one step;
journals before k are then of no use. So at every moment a checkpoint and all notes since are there.
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
"""Kind of a note beside those of a course: [JOIN, robots, agent, arithmetic]; the agent hosts them from now on."""


class CheckpointWriter:
    """Keeps a run in the folder of its run directory."""

    def __init__(
        self, directory: Path, period: float, name: str, run: str, *, number: int = 0, notes: int | None = None
    ) -> None:
        """`number` of the last checkpoint, and checksum of all `notes`, of a run that is resumed."""
        self._folder = directory / FOLDER
        self._period, self._name, self._run = period, name, run
        self._number = number
        self._saved = time.monotonic()
        self._writing: Future[None] | None = None
        self._writer = ThreadPoolExecutor(1, "checkpoint")
        self._lock = threading.Lock()
        self._written = 0
        self._journal: Journal | None = None
        # Notes of another run never fit, as each run begins with a checksum of its own.
        self._notes = secrets.randbits(32) if notes is None else notes
        self._digest_input: BinaryIO | None = None
        self._state: os.stat_result | None = None
        """Status of the file that was written last."""
        self.hosts: dict[int, Join] = {}
        """The last Join that was accepted for each robot, as the run was when it began to be kept."""
        self.renewed: set[int] = set()
        """Robots whose agents have joined, and answered no tick yet."""

    def begin(self, run: Run) -> None:
        """Keep a run that begins, in a run directory that was cleared."""
        try:
            self._folder.mkdir()
            self.follow(run, run.metrics.link_errors.digest.record_input(self._folder / DIGEST_INPUT), {}, set())
        except OSError as error:
            raise FesError(f"cannot keep checkpoints: {reason(error)}") from None

    def follow(
        self,
        run: Run,
        trail: BinaryIO,
        hosts: dict[int, Join],
        renewed: set[int],
        elapsed: float = 0.0,
    ) -> None:
        """Take notes of a run from its present tick on, and keep it as it is."""
        self._digest_input, self.hosts, self.renewed = trail, hosts, renewed
        self.save(run, hosts, elapsed, at_once=True)
        run.note = self.note

    @property
    def due(self) -> bool:
        """Whether it is time for another checkpoint."""
        busy = self._writing is not None and not self._writing.done()
        return not busy and time.monotonic() - self._saved >= self._period

    def note(self, note: list[Any]) -> None:
        """Keep a note."""
        renew(self.renewed, note)
        if self._journal is not None:
            self._journal.add(note)

    def check(self) -> None:
        """Raise the FesError for which there are no more notes, if there is one."""
        if self._journal is not None and self._journal.failure is not None:
            raise self._journal.failure

    def save(self, run: Run, hosts: dict[int, Join], elapsed: float, *, at_once: bool = False) -> None:
        """Keep the run as it is between two ticks, beside it or `at_once`; raises FesError where that fails."""
        if self._writing is not None and self._writing.done():
            self._writing.result()
        self.check()
        assert self._digest_input is not None
        loss = self._loss_of_digest_input(run)
        if loss is not None:
            raise FesError(f"cannot keep a checkpoint: {loss}")
        before = self._journal
        notes = self._notes if before is None else before.checksum
        self._number += 1
        self._saved = time.monotonic()
        kept = Snapshot(
            self._number,
            self._name,
            self._run,
            run.world.scenario,
            run.scenario,
            run.state,
            run.metrics,
            dict(hosts),
            sorted(self.renewed),
            dict(run.excluded),
            dict(run.beacons),
            run.recorder.pause() if run.recorder is not None else None,
            elapsed,
            notes,
        )
        told = snapshot.pack(kept)
        self._journal = Journal(self._folder / f"journal-{self._number}", self._number, notes)
        if before is not None:
            before.close()
        files = [self._digest_input.fileno()] + ([run.recorder.fileno] if run.recorder is not None else [])
        if at_once:
            self._write(self._number, told, files)
        else:
            self._writing = self._writer.submit(self._write, self._number, told, files)

    def losses(self, run: Run) -> list[str]:
        """One text per file of the current checkpoint that was removed or cut from outside."""
        journal, state, path = self._journal, self._state, self._folder / STATE
        if journal is None or journal.failure is not None:
            return []
        found = [self._loss_of_digest_input(run), (loss := journal.loss()) and f"{journal.path} {loss}"]
        if state is not None and not (path.exists() and os.path.samestat(path.stat(), state)):
            found.append(f"{path} was removed or replaced")
        return [one for one in found if one is not None]

    def close(self, run: Run) -> None:
        """Keep no more of a run."""
        with contextlib.suppress(OSError), self._lock:
            for loss in self.losses(run):
                _logger.warning("%s during the run: it could not have been resumed", loss)
        self._writer.shutdown(wait=False, cancel_futures=True)
        with self._lock:
            self._written = self._number + 1  # whatever is still to be written is not
            run.note = lambda note: None
            run.metrics.link_errors.digest.close()
            if self._journal is not None:
                self._journal.close()
                self._journal = None

    def discard(self, run: Run) -> None:
        """The run is over: there is nothing to go on from."""
        self.close(run)
        clear(self._folder.parent)

    def _loss_of_digest_input(self, run: Run) -> str | None:
        assert self._digest_input is not None
        self._digest_input.flush()
        path = self._folder / DIGEST_INPUT
        loss = hashed_file.loss(path, self._digest_input.fileno(), run.metrics.link_errors.digest.length)
        return loss and f"{path} {loss}"

    def _write(self, number: int, told: bytes, files: list[int]) -> None:
        with self._lock:
            if number < self._written:
                return  # a later one was quicker
            self._written = number
            try:
                for number_of_file in files:
                    os.fsync(number_of_file)
                part = self._folder / f".{STATE}"
                with part.open("wb") as file:
                    file.write(told)
                    file.flush()
                    os.fsync(file.fileno())
                    written = os.fstat(file.fileno())
                os.replace(part, self._folder / STATE)
                self._state = written
            except OSError as error:
                raise FesError(f"cannot keep a checkpoint: {reason(error)}") from None
            for old in [*self._folder.glob("journal-*"), *self._folder.glob("log-*")]:
                if _number(old) < number:
                    old.unlink(missing_ok=True)


def clear(directory: Path) -> None:
    """Leave nothing in a run directory to go on from."""
    (directory / FOLDER / STATE).unlink(missing_ok=True)  # first: without the rest it would be an older run
    shutil.rmtree(directory / FOLDER, ignore_errors=True)


def has_checkpoint(directory: Path) -> bool:
    """Whether a run directory has a checkpoint: its run is not over."""
    return (directory / FOLDER / STATE).exists()


def renew(renewed: set[int], note: list[Any]) -> None:
    """Bring the robots whose agents are new up to date with a note."""
    if note[0] == JOIN:
        renewed.update(note[1])
    elif note[0] == TICK and renewed:
        renewed.difference_update([robot for robot, command in enumerate(note[2]) if command])


def journals(directory: Path, number: int) -> list[Path]:
    """The journals of a run directory that belong to its checkpoint `number`, in order."""
    found = sorted((directory / FOLDER).glob("journal-*"), key=_number)
    return [path for path in found if _number(path) >= number]


def last(directory: Path, number: int) -> int:
    """The number of the last checkpoint that was begun after checkpoint `number`, or of this one."""
    return max([number, *map(_number, journals(directory, number))])


def log_of(directory: Path, number: int) -> Path:
    """Path of the log as checkpoint `number` knew it."""
    aside = directory / FOLDER / f"log-{number}"
    return aside if aside.exists() else directory / NAME


def set_log_aside(directory: Path, number: int) -> Path:
    """The log as checkpoint `number` knew it, where nobody writes any more; raises OSError."""
    found, aside = log_of(directory, number), directory / FOLDER / f"log-{number}"
    if found != aside:
        os.replace(found, aside)
    return aside


def _number(path: Path) -> int:
    text = path.name.rpartition("-")[2]
    return int(text) if text.isascii() and text.isdigit() else -1
