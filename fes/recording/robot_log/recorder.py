"""The robot's side of its log: it hands each step to the process that writes it, and never waits for that process.

A run waits for a writer that is behind. A robot must not: it drops steps, and the log counts them. A full disk or a
killed writer costs the log and one warning, and the robot continues.
"""

import logging
import platform
import threading
import time
from collections.abc import Callable, Sequence
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from fes.errors import FesError
from fes.protocol import world_info
from fes.recording.layout import AT_ITS_END, MAX_JSON
from fes.recording.robot_log.layout import KIND, LOST, MAX_EVENT, MAX_EVENTS, ROBOT_LOG, Fix, Header, counted
from fes.recording.writer.connection import LogWriter
from fes.recording.writer.frames import INFO, ROBOT, ROBOT_EVENT, STEP, WARNING
from fes.system import fingerprint, strict_json

if TYPE_CHECKING:
    from fes.recording.writer.log_file import LogFile

PATIENCE = 5.0
"""Longest time in which the writer makes no progress while the log is closed [s]."""

_SEQUENCE = 0xFFFFFFFF
_LIBRARIES = ("numpy", "mcap", "eclipse-zenoh")


def _warn(text: str) -> None:
    logging.getLogger("robot").warning("%s", text)


class RobotLog:
    """Context that writes the log of one robot, from one thread; after its start it raises no error."""

    def __init__(
        self,
        path: Path,
        header: Header,
        warn: Callable[[str], None] = _warn,
        clock: Callable[[], int] = time.monotonic_ns,
        writer: "Callable[[Path], LogWriter | LogFile]" = LogWriter,
    ) -> None:
        """Raises FesError if the file cannot be created, or its writer cannot be started.

        `warn` gets each warning, possibly in another thread. `clock` is the monotonic clock of events [ns]. A LogFile
        as `writer` needs no process.
        """
        content = strict_json.dumps(_content(header))
        if len(content) > MAX_JSON:
            raise FesError(f"{path}: the header has {len(content):,} bytes, of at most {MAX_JSON:,}")
        self.path = path
        self._header, self._warn, self._clock = header, warn, clock
        self._steps = self._events = 0  # events since the last step
        self._tick: int | None = None
        self._lost = [0, 0]
        """Steps and events that were dropped since the last one that was not."""
        self._dropped = 0
        self._is_closed = self._is_failed = self._is_behind = False
        self._watch: threading.Thread | None = None
        self._log = writer(path)
        self._offer(
            header.monotonic_ns, [[ROBOT, content.encode(), INFO, f"robot {header.robot} of run {header.run}"]]
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: object) -> None:
        if error is None:
            self.finish()
        else:
            self.finish(str(error) if isinstance(error, FesError) else "it was stopped")

    @property
    def lost(self) -> int:
        """Number of steps so far that are not in the log."""
        return self._dropped

    def tick(
        self,
        tick: int,
        observation: bytes,
        beacons: Sequence[bytes],
        beacon: bytes,
        command: bytes,
        monotonic_ns: int,
        fix: Fix | None = None,
    ) -> None:
        """Add a step: the Observation and the Beacons given to the crew, and the Beacon and Command it returned.

        The `beacons` are of tick - 1, in id order. Steps are in order of their ticks. A step that the writer does not
        take at once is dropped.
        """
        number, self._steps, self._tick, self._events = self._steps, self._steps + 1, tick, 0
        raw = None if fix is None else [int(fix.stamp_ns), *map(float, fix.pose)]
        step = [STEP, tick, number, monotonic_ns, observation, list(beacons), beacon, command, raw]
        if not self._offer(monotonic_ns, [*self._loss(monotonic_ns), step]):
            self._lost[0] += 1
            self._dropped += 1

    def event(self, kind: str, text: str, **values: Any) -> None:
        """Add an event: its kind, a line for viewers, and values for programs."""
        now, self._events = self._clock(), self._events + 1
        is_allowed = self._events < MAX_EVENTS  # a reader would reject the log
        if not is_allowed or not self._offer(now, [*self._loss(now), self._event(now, kind, text, values)]):
            self._lost[1] += 1

    def finish(self, reason: str = AT_ITS_END, patience: float = PATIENCE) -> None:
        """Close the log with the reason for its end; a writer without progress for `patience` [s] is killed."""
        if self._is_closed:
            return
        self._is_closed = True
        if self._watch is not None:
            self._watch.join(patience)
        if self._is_failed:
            return
        ended = {"ended": reason[:MAX_EVENT], "steps": str(self._steps)}
        try:
            damage = self._log.finish(ended, patience)
        except FesError as error:
            self._warn(f"{error}: the robot's log has no end")
        else:
            if damage is not None:
                self._warn(f"{self.path} {damage} during the run: the log is incomplete")

    def _loss(self, now: int) -> list[list[Any]]:
        """The event that counts what was dropped; none if nothing was."""
        steps, events = self._lost
        if not steps and not events:
            return []
        text = f"lost: {counted(steps)} and {counted(events, 'event')} before this are not in the log"
        return [self._event(now, LOST, text, {"steps": steps, "events": events}, WARNING)]

    def _event(self, now: int, kind: str, text: str, values: dict[str, Any], level: int = INFO) -> list[Any]:
        text = text[:MAX_EVENT]
        event = {"kind": kind[:MAX_EVENT], "text": text, "monotonic_ns": now, "tick": self._tick, "values": values}
        try:
            content = strict_json.dumps(event)
        except (TypeError, ValueError, RecursionError):  # values that JSON does not have
            content = ""
        if not content or len(content) > 4 * MAX_EVENT:
            content = strict_json.dumps({**event, "values": {"text": repr(values)[:MAX_EVENT]}})
        return [ROBOT_EVENT, content.encode(), level, text]

    def _offer(self, monotonic_ns: int, messages: list[list[Any]]) -> bool:
        """Hand messages to the writer; False if it did not take them."""
        if self._is_closed or self._is_failed:
            return False
        elapsed = max(monotonic_ns - self._header.monotonic_ns, 0)
        try:
            is_taken = self._log.offer(max(self._steps - 1, 0) & _SEQUENCE, self._header.wall_ns + elapsed, messages)
        except FesError as error:  # only of a writer in this process
            if not isinstance(self._log, LogWriter):
                self._log.close()
            self._fail(error)
            return False
        if is_taken:
            self._lost = [0, 0]
        elif isinstance(self._log, LogWriter) and self._log.is_lost:
            self._is_failed = True
            self._watch = threading.Thread(target=self._explain, args=[self._log], name="lost log", daemon=True)
            self._watch.start()
        elif not self._is_behind:
            self._is_behind = True
            self._warn(f"the process that writes {self.path} is behind: its log lacks steps")
        return is_taken

    def _explain(self, log: LogWriter) -> None:
        """Warn with the reason for which a writer has ended; its end may take a while."""
        self._fail(log.failure())

    def _fail(self, error: FesError) -> None:
        self._is_failed = True
        self._warn(f"{error}: the robot continues without a log")


def _content(header: Header) -> dict[str, Any]:
    """The header as a table of JSON."""
    versions = {"fes": world_info.version(), **{name: metadata.version(name) for name in _LIBRARIES}}
    return {
        "kind": KIND,
        "format": ROBOT_LOG,
        **header._asdict(),
        "config": header.config.model_dump(mode="json", by_alias=True),
        "arithmetic": fingerprint.table(),
        "versions": {**versions, "python": platform.python_version(), "machine": platform.machine()},
    }
