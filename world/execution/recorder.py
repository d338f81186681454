"""The log of a run, run.mcap: everything that was said, tick by tick, and what viewers show of it.

The order is canonical: of a tick first Observations, Beacons and Commands, each with the payloads of all robots in id
order, then what was set, then, ten times a simulated second, the Report and what viewers show: see docs/log.md.
A chunk never divides a tick and is handed to the system when it is closed, so that whatever becomes of this process,
the file can be read up to its last chunk.
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
from world.config.scenario import Scenario
from world.metrics import report_builder
from world.metrics.collector import MetricsCollector

_ENDED = 4096  # bytes; room beside a summary for how the run ended

VIEW_PERIOD = 0.1
"""Simulated time between two Reports [s]."""

MAX_VIEWED = 256
"""With more robots than this there is nothing for viewers: a topic for each link would be too many."""


@dataclass(frozen=True)
class LogPosition:
    """A log up to one tick, to be gone on with."""

    size: int
    """Bytes of the file that are whole."""
    sha256: str
    """SHA-256 of these bytes, in hexadecimal."""
    tick: int
    told: tuple[int, float]
    pending: list[tuple[int, str, Any]]
    present: dict[int, list[list[int]]]
    excluded: dict[int, list[tuple[list[int], str]]]


class Recorder:
    """Writes the log of one run while the block lasts; raises FesError where the file cannot be written."""

    def __init__(
        self,
        path: Path,
        scenario: Scenario,
        name: str,
        backend: str,
        before: tuple[Path, LogPosition] | None = None,
    ) -> None:
        """`before` is the log so far, in another file, where a run is gone on with."""
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
        self._told = (0, 0.0)
        self._file = McapFile(path)
        if before is None:
            self._begin(backend)
            return
        source, kept = before
        self._file.copy(source, kept.size)
        self._tick, self._told = kept.tick, kept.told
        self._pending, self._present = list(kept.pending), dict(kept.present)
        self._excluded = dict(kept.excluded)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: object) -> None:
        if error is None:
            self._end(None)
        else:
            self._end(str(error) if isinstance(error, FesError) else "it was stopped")
        if self._file.loss is not None:
            said = f"{self.path} {self._file.loss} during the run: the log is incomplete"
            if error is None:
                raise FesError(said)
            logging.getLogger("world").warning("%s", said)

    def add(
        self, metrics: MetricsCollector, twists: Floats, said: TickPayloads, alive: Bytes, elapsed: float
    ) -> None:
        """Add the last tick of `metrics`, `elapsed` [s; wall clock] after tick 0, and what made it.

        `twists` [n, 2]; `alive` [n].
        """
        tick = self._tick = metrics.state.tick
        for name, payloads in zip(("Observations", "Beacons", "Commands"), said, strict=True):
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
        """A person sets a field of the channel: it holds from `tick` on, which has not been added yet."""
        self._pending.append((tick, path, value))

    def attend(self, tick: int, robots: list[int]) -> None:
        """From `tick` on, which has not been added yet, these robots take part, otherwise than by schedule."""
        self._present.setdefault(tick, []).append(robots)

    def exclude(self, tick: int, robots: list[int], reason: str) -> None:
        """Note that these robots are excluded for their fault from `tick` on, which has not been added yet."""
        self._excluded.setdefault(tick, []).append((robots, reason))

    @property
    def fileno(self) -> int:
        """The number of the open file."""
        return self._file.fileno

    def pause(self) -> LogPosition:
        """The log up to the last tick that was added: from now on a reader finds all of it."""
        return LogPosition(
            self._file.close_chunk(),
            self._file.sha256,
            self._tick,
            self._told,
            list(self._pending),
            dict(self._present),
            dict(self._excluded),
        )

    def conclude(self, summary: dict[str, Any] | None) -> None:
        """Keep the summary of what was reached."""
        self._summary = summary

    def _begin(self, backend: str) -> None:
        versions = {name: metadata.version(name) for name in ("numpy", "mcap", "eclipse-zenoh")}
        tables = self._scenario.model_dump(mode="json", by_alias=True, exclude_none=True)
        told = {
            "log": schemas.VERSION,
            "name": self._name,
            "backend": backend,
            "scenario": tomli_w.dumps(tables),
            "arithmetic": fingerprint.table(),
            "versions": {
                "fes": world_info.version(),
                **versions,
                "python": platform.python_version(),
                "machine": platform.machine(),
            },
        }
        self._put("/scenario", schemas.SCENARIO, strict_json.dumps(told).encode())
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
        told = strict_json.dumps(self._summary)
        if self._summary is not None and len(told) <= MAX_JSON - _ENDED:
            ended["summary"] = told
        self._file.finish(SUMMARY, ended)

    def _set_by_persons(self, tick: int) -> None:
        while self._pending and self._pending[0][0] <= tick:
            at, path, value = self._pending.pop(0)
            self._set(at, "person", path, value)

    def _set(self, tick: int, by: str, path: str, value: Any) -> None:
        event = {"tick": tick, "what": "set", "by": by, "path": path, "value": value}
        self._put("/events", schemas.EVENT, strict_json.dumps(event).encode())
        self._remark(viewer_topics.INFO, f"{path} = {value}, by {by}")

    def _report(self, metrics: MetricsCollector, twists: Floats, alive: Bytes, elapsed: float) -> None:
        (told_at, then), ticks = self._told, metrics.link_errors.ticks
        self._told = ticks, elapsed
        rate = (ticks - told_at) / (elapsed - then) if elapsed > then else 0.0
        report = report_builder.build(metrics, self._name, alive, elapsed, rate)
        self._put_message("/report", viewer_topics.team(report, encode_report(report)))
        if not self._viewed:
            return
        at = viewer_topics.timestamp(self._now)
        self._put_message("/tf", viewer_topics.transforms(report, at))
        self._put_message("/scene/links", viewer_topics.links(report, at))
        for robot, state in enumerate(viewer_topics.robots(report, twists, metrics.telemetry)):
            self._put_message(f"/robot/{robot}/state", state)
        for a, b, state in viewer_topics.pairs(report):
            self._put_message(f"/link/{a}-{b}/state", state)

    def _remark(self, level: "Log.Level.ValueType", text: str) -> None:
        self._put_message("/log", viewer_topics.remark(viewer_topics.timestamp(self._now), level, text))

    @property
    def _now(self) -> int:
        """Simulated time [ns]."""
        return round(max(0, self._tick) * self._scenario.run.dt * 1e9)

    def _put_message(self, topic: str, message: Message) -> None:
        self._put(topic, type(message), message.SerializeToString())

    def _put(self, topic: str, schema: Schema, payload: bytes) -> None:
        self._file.put(topic, schema, payload, self._now, max(0, self._tick))


def report_period(scenario: Scenario) -> int:
    """Ticks between two Reports of a log."""
    return counts.ticks_of(VIEW_PERIOD, scenario.run.dt)
