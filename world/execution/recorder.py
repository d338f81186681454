"""The log of a run, run.mcap: every message, tick by tick, and topics for viewers.

The order is canonical (see docs/reference/log.md). A tick begins with its Observations, Beacons and Commands, each
with the payloads of all robots in id order. Events follow. Ten times per simulated second a Report and the topics
for viewers end the tick.

The messages of a tick are one frame, which a process of its own writes (`fes.recording.writer`). It also writes what
it has received when this process is killed.
"""

import logging
import platform
from collections.abc import Callable
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import tomli_w

from fes.arrays.types import Bytes, Floats
from fes.errors import FesError
from fes.model import counts
from fes.protocol import world_info
from fes.protocol.report import encode_report
from fes.recording import schemas
from fes.recording.layout import AT_ITS_END, MAX_JSON, PackedPayloads, TickPayloads
from fes.recording.writer import frames
from fes.recording.writer.connection import LogWriter
from fes.recording.writer.frames import BODIES, EVENT, INFO, PACKED, PAYLOADS, REMARK, REPORT, SCENARIO, WARNING
from fes.system import fingerprint, strict_json
from world.config.outside import extensions
from world.config.scenario import Scenario
from world.metrics import report_builder
from world.metrics.collector import MetricsCollector

if TYPE_CHECKING:
    from fes.recording.writer.log_file import LogFile

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
        writer: "Callable[[Path], LogWriter | LogFile]" = LogWriter,
    ) -> None:
        """`before` is the log so far of a resumed run, in another file. A LogFile as `writer` needs no process."""
        self.path = path
        self._scenario, self._name = scenario, name
        self._changes, self._dt = scenario.changes, scenario.run.dt
        self._period, self._last = report_period(scenario), scenario.ticks - 1
        self._viewed = scenario.robots.number <= MAX_VIEWED
        self._summary: dict[str, Any] | None = None
        self._pending: list[tuple[int, str, Any]] = []
        self._present: dict[int, list[list[int]]] = {}
        self._excluded: dict[int, list[tuple[list[int], str]]] = {}
        self._tick = -1
        self._reported = (0, 0.0)
        self._log = writer(path)
        if before is None:
            self._begin(backend)
            return
        source, position = before
        self._log.copy(source, position.size)
        self._tick, self._reported = position.tick, position.reported
        self._pending, self._present = list(position.pending), dict(position.present)
        self._excluded = dict(position.excluded)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: object) -> None:
        if error is None:
            damage = self._end(None)
        else:
            damage = self._end(str(error) if isinstance(error, FesError) else "it was stopped")
        if damage is not None:
            loss = f"{self.path} {damage} during the run: the log is incomplete"
            if error is None:
                raise FesError(loss)
            logging.getLogger("world").warning("%s", loss)

    def add(
        self,
        metrics: MetricsCollector,
        twists: Floats,
        payloads: TickPayloads | PackedPayloads,
        alive: Bytes,
        elapsed: float,
    ) -> None:
        """Add the last tick of `metrics`, and its messages.

        `twists` [n, 2]; `alive` [n] is 1 for each robot with a token; `elapsed` [s; wall clock] since tick 0.
        """
        tick = metrics.state.tick
        kind = PACKED if isinstance(payloads, PackedPayloads) else PAYLOADS
        messages: list[list[Any]] = [[kind, *payloads]]
        if tick in self._changes:
            for path, value in self._changes[tick].items():
                messages += _set(tick, "schedule", path, value)
        if self._pending:
            messages += self._set_by_persons(tick)
        for robots, reason in self._excluded.pop(tick, []):
            messages.append(_event({"tick": tick, "what": "excluded", "robots": robots, "reason": reason}))
            messages.append([REMARK, WARNING, f"robots {robots} are excluded from tick {tick} on: {reason}"])
        for robots in self._present.pop(tick, []):
            messages.append(_event({"tick": tick, "what": "present", "robots": robots}))
            messages.append([REMARK, WARNING, f"{len(robots)} robots take part from tick {tick} on: {robots}"])
        if tick % self._period == 0 or tick == self._last:
            messages.append(self._report(metrics, twists, alive, elapsed))
        self._write(tick, messages)
        self._tick = tick

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
        return self._log.fileno

    def pause(self) -> LogPosition:
        """Close the chunk; returns the position after the last tick, up to which a reader can now read."""
        return LogPosition(
            *self._log.position(),
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
        robots = self._scenario.robots.number
        seed, ticks = self._scenario.run.seed, self._scenario.ticks
        messages: list[list[Any]] = [
            [SCENARIO, strict_json.dumps(head).encode()],
            [REMARK, INFO, f"{self._name}: {robots} robots, seed {seed}, {ticks} ticks"],
            *([[BODIES, robots]] if self._viewed else []),
        ]
        self._write(0, messages)

    def _end(self, reason: str | None) -> str | None:
        """Write the end of the run; returns damage by other programs, in words."""
        ticks = self._tick = self._tick + 1
        reason = reason[: _ENDED // 8] if reason else None
        because = f": {reason}" if reason else ""
        level = WARNING if reason else INFO
        messages = [
            *self._set_by_persons(ticks),
            _event({"tick": ticks, "what": "end", **({"reason": reason} if reason else {})}),
            [REMARK, level, f"the run is over after {ticks} ticks{because}"],
        ]
        self._write(ticks, messages)
        ended = {"ended": reason or AT_ITS_END}
        summary = strict_json.dumps(self._summary)
        if self._summary is not None and len(summary) <= MAX_JSON - _ENDED:
            ended["summary"] = summary
        return self._log.finish(ended)

    def _set_by_persons(self, tick: int) -> list[list[Any]]:
        messages: list[list[Any]] = []
        while self._pending and self._pending[0][0] <= tick:
            since, path, value = self._pending.pop(0)
            messages += _set(since, "person", path, value)
        return messages

    def _report(self, metrics: MetricsCollector, twists: Floats, alive: Bytes, elapsed: float) -> list[Any]:
        (ticks_before, before), ticks = self._reported, metrics.link_errors.ticks
        self._reported = ticks, elapsed
        rate = (ticks - ticks_before) / (elapsed - before) if elapsed > before else 0.0
        report = report_builder.build(metrics, self._name, alive, elapsed, rate)
        arrays = frames.arrays(report, twists, metrics.telemetry) if self._viewed else None
        return [REPORT, encode_report(report), frames.numbers(report), arrays]

    def _write(self, tick: int, messages: list[list[Any]]) -> None:
        self._log.write(tick, round(tick * self._dt * 1e9), messages)


def _event(event: dict[str, Any]) -> list[Any]:
    return [EVENT, strict_json.dumps(event).encode()]


def _set(tick: int, by: str, path: str, value: Any) -> list[list[Any]]:
    """The messages about a field that was set."""
    event = {"tick": tick, "what": "set", "by": by, "path": path, "value": value}
    return [_event(event), [REMARK, INFO, f"{path} = {value}, by {by}"]]


def report_period(scenario: Scenario) -> int:
    """Ticks between two Reports of a log."""
    return counts.ticks_of(VIEW_PERIOD, scenario.run.dt)
