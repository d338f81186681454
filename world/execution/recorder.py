"""The log of a run, run.mcap: every message, tick by tick, and topics for viewers.

The order is canonical (see docs/reference/log.md). A tick begins with its Observations, Beacons and Commands, each
with the payloads of all robots in id order. Events follow. Ten times per simulated second a Report and the topics
for viewers end the tick. A chunk never divides a tick, and is handed to the operating system when it is closed.
So the file can be read up to its last chunk, however this process ends.
"""

import logging
import platform
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Any, Self

import tomli_w
from foxglove_schemas_protobuf.Log_pb2 import Log
from google.protobuf.message import Message

from fes.arrays.types import Bytes, Floats
from fes.errors import FesError
from fes.model import counts
from fes.protocol import world_info
from fes.protocol.report import encode_report
from fes.recording import messages_pb2, schemas, viewer_topics
from fes.recording.layout import AT_ITS_END, MAX_JSON, SUMMARY, TickPayloads
from fes.recording.mcap_file import McapFile, Schema
from fes.system import fingerprint, strict_json
from world.config.outside import extensions
from world.config.scenario import Scenario
from world.metrics import report_builder
from world.metrics.collector import MetricsCollector

_ENDED = 4096  # bytes reserved beside a summary for the reason why the run ended

VIEW_PERIOD = 0.1
"""Simulated time between two Reports [s]."""

MAX_VIEWED = 256
"""With more robots than this a log has no topics for viewers, because one per link would be too many."""


@dataclass(frozen=True)
class LogPosition:
    """A log up to one tick, from which it can be continued."""

    size: int
    """Length of the file up to its last complete chunk [bytes]."""
    sha256: str
    """SHA-256 of these bytes, in hexadecimal."""
    tick: int
    reported: tuple[int, float]
    """Ticks, and wall-clock time since tick 0 [s], at the last Report."""
    pending: list[tuple[int, str, Any]]
    """Changes by persons that no tick holds yet: tick, path, value."""
    present: dict[int, list[list[int]]]
    """Tick -> robots that take part from then on, where the schedule has others."""
    excluded: dict[int, list[tuple[list[int], str]]]
    """Tick -> robots that are excluded from then on, and the reason."""


class Recorder:
    """Context that writes the log of one run; raises FesError if the file cannot be written."""

    def __init__(
        self,
        path: Path,
        scenario: Scenario,
        name: str,
        backend: str,
        before: tuple[Path, LogPosition] | None = None,
    ) -> None:
        """`before` is the log so far of a resumed run, in another file."""
        self.path = path
        self._scenario, self._name = scenario, name
        self._changes = scenario.changes
        self._period = report_period(scenario)
        self._viewed = scenario.robots.number <= MAX_VIEWED
        self._summary: dict[str, Any] | None = None
        self._pending: list[tuple[int, str, Any]] = []
        self._present: dict[int, list[list[int]]] = {}
        self._excluded: dict[int, list[tuple[list[int], str]]] = {}
        self._tick = -1
        self._reported = (0, 0.0)
        self._file = McapFile(path)
        if before is None:
            self._begin(backend)
            return
        source, position = before
        self._file.copy(source, position.size)
        self._tick, self._reported = position.tick, position.reported
        self._pending, self._present = list(position.pending), dict(position.present)
        self._excluded = dict(position.excluded)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: object) -> None:
        if error is None:
            self._end(None)
        else:
            self._end(str(error) if isinstance(error, FesError) else "it was stopped")
        if self._file.loss is not None:
            loss = f"{self.path} {self._file.loss} during the run: the log is incomplete"
            if error is None:
                raise FesError(loss)
            logging.getLogger("world").warning("%s", loss)

    def add(
        self, metrics: MetricsCollector, twists: Floats, tick_payloads: TickPayloads, alive: Bytes, elapsed: float
    ) -> None:
        """Add the last tick of `metrics`, and its messages.

        `twists` [n, 2]; `alive` [n] is 1 for each robot with a token; `elapsed` [s; wall clock] since tick 0.
        """
        tick = self._tick = metrics.state.tick
        for name, payloads in zip(("Observations", "Beacons", "Commands"), tick_payloads, strict=True):
            self._put_message(f"/{name.lower()}", getattr(messages_pb2, name)(tick=tick, payloads=payloads))
        for path, value in self._changes.get(tick, {}).items():
            self._set(tick, "schedule", path, value)
        self._set_by_persons(tick)
        for robots, reason in self._excluded.pop(tick, []):
            event = {"tick": tick, "what": "excluded", "robots": robots, "reason": reason}
            self._put("/events", schemas.EVENT, strict_json.dumps(event).encode())
            self._remark(viewer_topics.WARNING, f"robots {robots} are excluded from tick {tick} on: {reason}")
        for robots in self._present.pop(tick, []):
            event = {"tick": tick, "what": "present", "robots": robots}
            self._put("/events", schemas.EVENT, strict_json.dumps(event).encode())
            self._remark(viewer_topics.WARNING, f"{len(robots)} robots take part from tick {tick} on: {robots}")
        if tick % self._period == 0 or tick == self._scenario.ticks - 1:
            self._report(metrics, twists, alive, elapsed)
        self._file.settle()

    def change(self, tick: int, path: str, value: Any) -> None:
        """Note that a person set a field of the channel from `tick` on, which has not been added yet."""
        self._pending.append((tick, path, value))

    def attend(self, tick: int, robots: list[int]) -> None:
        """Note that these robots, not the scheduled ones, take part from `tick` on, which has not been added yet."""
        self._present.setdefault(tick, []).append(robots)

    def exclude(self, tick: int, robots: list[int], reason: str) -> None:
        """Note that these robots are excluded for their fault from `tick` on, which has not been added yet."""
        self._excluded.setdefault(tick, []).append((robots, reason))

    @property
    def fileno(self) -> int:
        """The number of the open file."""
        return self._file.fileno

    def pause(self) -> LogPosition:
        """Close the chunk; returns the position after the last tick, up to which a reader can now read."""
        return LogPosition(
            self._file.close_chunk(),
            self._file.sha256,
            self._tick,
            self._reported,
            list(self._pending),
            dict(self._present),
            dict(self._excluded),
        )

    def conclude(self, summary: dict[str, Any] | None) -> None:
        """Set the summary, which is written at the end."""
        self._summary = summary

    def _begin(self, backend: str) -> None:
        versions = {name: metadata.version(name) for name in ("numpy", "mcap", "eclipse-zenoh")}
        tables = self._scenario.model_dump(mode="json", by_alias=True, exclude_none=True)
        head = {
            "log": schemas.VERSION,
            "name": self._name,
            "backend": backend,
            "scenario": tomli_w.dumps(tables),
            "arithmetic": fingerprint.table(),
            "extensions": [entry.table for entry in extensions.of(self._scenario)],
            "versions": {
                "fes": world_info.version(),
                **versions,
                "python": platform.python_version(),
                "machine": platform.machine(),
            },
        }
        self._put("/scenario", schemas.SCENARIO, strict_json.dumps(head).encode())
        robots = self._scenario.robots.number
        seed, ticks = self._scenario.run.seed, self._scenario.ticks
        self._remark(viewer_topics.INFO, f"{self._name}: {robots} robots, seed {seed}, {ticks} ticks")
        if self._viewed:
            self._put_message("/scene/robots", viewer_topics.bodies(robots, viewer_topics.timestamp(0)))
        self._file.settle(at_once=True)

    def _end(self, reason: str | None) -> None:
        ticks = self._tick = self._tick + 1
        self._set_by_persons(ticks)
        reason = reason[: _ENDED // 8] if reason else None
        event = {"tick": ticks, "what": "end", **({"reason": reason} if reason else {})}
        self._put("/events", schemas.EVENT, strict_json.dumps(event).encode())
        because = f": {reason}" if reason else ""
        level = viewer_topics.WARNING if reason else viewer_topics.INFO
        self._remark(level, f"the run is over after {ticks} ticks{because}")
        ended = {"ended": reason or AT_ITS_END}
        summary = strict_json.dumps(self._summary)
        if self._summary is not None and len(summary) <= MAX_JSON - _ENDED:
            ended["summary"] = summary
        self._file.finish(SUMMARY, ended)

    def _set_by_persons(self, tick: int) -> None:
        while self._pending and self._pending[0][0] <= tick:
            since, path, value = self._pending.pop(0)
            self._set(since, "person", path, value)

    def _set(self, tick: int, by: str, path: str, value: Any) -> None:
        event = {"tick": tick, "what": "set", "by": by, "path": path, "value": value}
        self._put("/events", schemas.EVENT, strict_json.dumps(event).encode())
        self._remark(viewer_topics.INFO, f"{path} = {value}, by {by}")

    def _report(self, metrics: MetricsCollector, twists: Floats, alive: Bytes, elapsed: float) -> None:
        (ticks_before, before), ticks = self._reported, metrics.link_errors.ticks
        self._reported = ticks, elapsed
        rate = (ticks - ticks_before) / (elapsed - before) if elapsed > before else 0.0
        report = report_builder.build(metrics, self._name, alive, elapsed, rate)
        self._put_message("/report", viewer_topics.team(report, encode_report(report)))
        if not self._viewed:
            return
        time = viewer_topics.timestamp(self._now)
        self._put_message("/tf", viewer_topics.transforms(report, time))
        self._put_message("/scene/links", viewer_topics.links(report, time))
        for robot, state in enumerate(viewer_topics.robots(report, twists, metrics.telemetry)):
            self._put_message(f"/robot/{robot}/state", state)
        for a, b, state in viewer_topics.pairs(report):
            self._put_message(f"/link/{a}-{b}/state", state)

    def _remark(self, level: "Log.Level.ValueType", text: str) -> None:
        self._put_message("/log", viewer_topics.remark(viewer_topics.timestamp(self._now), level, text))

    @property
    def _now(self) -> int:
        """Simulated time of the last tick [ns]."""
        return round(max(0, self._tick) * self._scenario.run.dt * 1e9)

    def _put_message(self, topic: str, message: Message) -> None:
        self._put(topic, type(message), message.SerializeToString())

    def _put(self, topic: str, schema: Schema, payload: bytes) -> None:
        self._file.put(topic, schema, payload, self._now, max(0, self._tick))


def report_period(scenario: Scenario) -> int:
    """Ticks between two Reports of a log."""
    return counts.ticks_of(VIEW_PERIOD, scenario.run.dt)
