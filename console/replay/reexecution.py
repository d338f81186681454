"""A recorded run executed again: the world from the recorded Commands, robots from what they sensed and heard.

Whatever comes out is compared with the log, to the bit.
"""

from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np

from agents.control import contacts, crew, transmitter
from agents.runtime import marshalling as agent_marshalling
from agents.runtime.marshalling import MessageAssembler
from console.replay.difference import Difference, between, of_payloads, of_reports
from console.replay.log import Log
from fes.arrays.types import Floats, Ints
from fes.errors import FesError, MessageError
from fes.model.sensing import Telemetry
from fes.protocol import messages
from fes.protocol.messages import Beacon, Command, Observation
from fes.protocol.report import Report
from fes.recording.layout import TickPayloads
from fes.recording.ticks import LoggedTick
from fes.system import fingerprint, strict_json
from world.config import events
from world.config.scenario import agent_config
from world.execution import marshalling as world_marshalling
from world.execution.marshalling import CommandBatch
from world.execution.recorder import report_period
from world.metrics import report_builder
from world.metrics.collector import MetricsCollector
from world.metrics.summary import summarize
from world.simulation import truth
from world.simulation.truth import State

YEARS = 1e12
"""Longer than any run takes [s; wall clock]."""

T = TypeVar("T", Observation, Beacon, Command)


class Mismatch(FesError):
    """A run came out otherwise when executed again. A note shows whether another processor may be the cause."""

    def __init__(self, log: Log, found: Difference | str) -> None:
        super().__init__(found if isinstance(found, str) else found.told("in the log", "executed again"))
        self.add_note(f"recorded with {fingerprint.text(log.arithmetic)}; executed with {fingerprint.text()}")


@dataclass(frozen=True, eq=False)
class ReplayedTick:
    """One tick, as the world went through it again."""

    recorded: LoggedTick
    state: State
    twists: Floats
    """[n, 2] [m/s, rad/s]"""
    telemetry: Telemetry
    spoken: Ints
    """Tick of the command that each robot follows [n], -1 for none."""


def world(log: Log) -> Iterator[ReplayedTick]:
    """Every tick of a log, the world moved by the recorded Commands.

    Raises Mismatch where an Observation comes out otherwise, and FesError where the log is damaged.
    """
    again = truth.create(log.scenario)
    state, told = truth.start(again), CommandBatch(again.ids)
    before: ReplayedTick | None = None
    live = log.scenario.run.clock == "live"
    for tick in log.ticks():
        if before is not None:  # only now: after the last recorded tick nobody knows what would have come
            state = truth.step(again, before.state, before.twists)
        _check_schedule(log, tick)
        channel = state.channel
        for path, value in tick.changes:
            channel = events.changed(channel, {path: value}, log.scenario.run.dt)
        if channel is not state.channel:
            state = replace(state, channel=channel)
        for robots in tick.attended:
            state = truth.attend(state, np.isin(again.ids, robots))
        sensed = world_marshalling.observations(truth.observe(state), state.present, state.since)
        _compare(log, tick, tick.payloads._replace(observations=sensed))
        commands: list[Command | None] = [None] * len(again.ids)
        here = np.flatnonzero(state.present).tolist()
        if live:  # whoever is not heard of stops
            here = [robot for robot in here if tick.payloads.commands[robot]]
        given = _decoded(tick, messages.decode_command, tick.payloads.commands, here, held=live)
        for robot, command in zip(here, given, strict=True):
            commands[robot] = command
        twists, telemetry = told.read(commands)
        spoken = np.array([-1 if command is None else command.tick for command in commands])
        before = ReplayedTick(tick, state, twists, telemetry, spoken)
        yield before


def accounted(log: Log) -> Iterator[tuple[ReplayedTick, MetricsCollector]]:
    """Every tick of a log as `world` has it, and the account up to it.

    Raises Mismatch if a Report or, after the last tick, the summary comes out otherwise, and FesError if a Report is
    missing.
    """
    metrics, elapsed, period = MetricsCollector(log.scenario), 0.0, report_period(log.scenario)
    for moment in world(log):
        metrics.add(moment.state, moment.twists, moment.telemetry, moment.spoken)
        number, recorded = moment.recorded.number, moment.recorded.report
        if recorded is not None:
            elapsed = recorded.elapsed
            _check_report(log, metrics, recorded)
        elif number % period == 0 or number == log.scenario.ticks - 1:
            raise FesError(f"tick {number}: the Report that is due is not in the log")
        yield moment, metrics
    _check_summary(log, summary(log, metrics, elapsed))


def summary(log: Log, metrics: MetricsCollector, elapsed: float = 0.0) -> dict[str, Any]:
    """The summary of the ticks in `metrics`, with what is of the machine taken from the log, or from `elapsed`
    [s]."""
    wall = (log.summary or {}).get("wall_s")
    wall = float(wall) if isinstance(wall, int | float) and abs(wall) < YEARS else elapsed
    kept = (log.summary or {}).get("deadlines")
    if metrics.deadlines is not None and isinstance(kept, dict):  # the log cannot tell how late what came late was
        try:
            metrics.deadlines.late = np.array(kept.get("late"), dtype=np.int64)
            metrics.deadlines.slipped = float(kept.get("slipped_s", 0.0))
        except (TypeError, ValueError, OverflowError):
            raise FesError(f"{log.path}: the deadlines in its summary cannot be read") from None
    found: dict[str, Any] = strict_json.loads(strict_json.dumps(summarize(metrics, log.name, log.backend, wall)))
    return {**found, "arithmetic": dict(log.arithmetic)}


class ReplayedRobots:
    """Some robots of a log, executed again tick by tick by their own code."""

    def __init__(self, log: Log, ids: Collection[int]) -> None:
        if log.scenario.run.clock == "live":
            raise FesError(f"{log.path} is of the live clock: what came too late for a robot is not in it")
        robots = np.array(sorted(ids), dtype=np.int64)
        self._crew = crew.create(agent_config(log.scenario), robots)
        self._state = crew.start(self._crew)
        self._stack = MessageAssembler(robots)
        self._robots = robots.tolist()
        self._log = log
        self._before: LoggedTick | None = None

    def step(self, tick: LoggedTick) -> None:
        """Go through a tick, and compare each Beacon and Command; raises Mismatch."""
        here = [robot for robot in self._robots if tick.payloads.observations[robot]]
        sensed = dict(
            zip(here, _decoded(tick, messages.decode_observation, tick.payloads.observations, here), strict=True)
        )
        anew = np.array([robot in sensed and sensed[robot].since == tick.number for robot in self._robots])
        if anew.any():
            self._state = crew.forget(self._crew, self._state, anew)
        observations = self._stack.observations(
            [sensed.get(robot) or _absent(tick.number, robot) for robot in self._robots]
        )
        heard = []
        if self._before is not None:
            spoken = self._before.payloads.beacons
            peers = [peer for peer in np.unique(observations.in_range.peers).tolist() if spoken[peer]]
            heard = _decoded(self._before, messages.decode_beacon, spoken, peers)
        beacons = self._stack.beacons(tick.number - 1, heard)
        self._state, said, twists = crew.step(self._crew, self._state, observations, beacons)
        if not contacts.all_here(self._state.contacts, observations):
            raise FesError(f"tick {tick.number - 1}: a Beacon that was decoded is not in the log")
        told = crew.telemetry(self._crew, self._state)
        broken = transmitter.damaging(self._crew.transmitters, tick.number)
        for robot, whole, command in agent_marshalling.encode_tick(said, twists, told):
            if robot not in sensed:
                continue
            beacon = b"" if robot in broken else whole
            recorded = tick.payloads.beacons[robot], tick.payloads.commands[robot]
            for message, one, other in zip(("Beacon", "Command"), recorded, (beacon, command), strict=True):
                if one != other:
                    raise Mismatch(self._log, of_payloads(tick.number, message, robot, one, other))
        self._before = tick


def _absent(tick: int, robot: int) -> Observation:
    """What a robot that is not there senses: whatever it makes of it is forgotten when it comes back."""
    nothing = np.zeros(0, dtype=np.int64)
    return Observation(tick, robot, (0.0, 0.0, 0.0), nothing, nothing.astype(np.uint8), over=False, since=0)


def report(metrics: MetricsCollector, like: Report) -> Report:
    """The Report of the last tick of `metrics`, with what is of the machine taken from `like`."""
    if metrics.deadlines is not None and len(like.late):
        metrics.deadlines.late = like.late
    return report_builder.build(metrics, like.scenario, like.alive, like.elapsed, like.ticks_per_s)


def _check_report(log: Log, metrics: MetricsCollector, recorded: Report) -> None:
    """Raise Mismatch unless the Report of the last tick of `metrics` is the recorded one."""
    found = of_reports(recorded, report(metrics, recorded))
    if found is not None:
        raise Mismatch(log, found)


def _check_summary(log: Log, found: dict[str, Any]) -> None:
    """Raise Mismatch unless the summary in the log, if it has one, equals the one that was found."""
    if log.summary is None:
        return
    for key in [*log.summary, *(key for key in found if key not in log.summary)]:
        mine, theirs = (strict_json.dumps(one[key]) if key in one else None for one in (log.summary, found))
        if mine != theirs:
            told = [repr(one[key]) if key in one else "missing" for one in (log.summary, found)]
            raise Mismatch(log, f"summary: {key} is {told[0]} in the log and {told[1]} executed again")


def _check_schedule(log: Log, tick: LoggedTick) -> None:
    """Raise Mismatch unless the log says that at this tick was set what the scenario schedules."""
    planned = list(log.scenario.changes.get(tick.number, {}).items())
    if tick.scheduled != planned:
        raise Mismatch(log, Difference(tick.number, "events", None, "what was scheduled", tick.scheduled, planned))


def _decoded(
    tick: LoggedTick, decode: Callable[[bytes], T], payloads: list[bytes], robots: Iterable[int], held: bool = False
) -> list[T]:
    """The messages of some robots at a tick; raises FesError where one is missing, damaged or another's.

    With `held` they may be of earlier ticks.
    """
    found = []
    for robot in robots:
        try:
            one = decode(payloads[robot])
            name = type(one).__name__
            of_now = one.tick <= tick.number if held else one.tick == tick.number
            if not of_now or one.robot != robot:
                raise MessageError(name, "is of another tick or robot", f"tick {one.tick}, robot {one.robot}")
            peers = one.in_range if isinstance(one, Observation) else one.links
            if len(peers) and not 0 <= peers.min() <= peers.max() < len(payloads):
                raise MessageError(name, f"names a robot that is not one of {len(payloads)}", str(peers.tolist()))
        except MessageError as error:
            raise FesError(f"tick {tick.number}, robot {robot}: {error}") from None
        found.append(one)
    return found


def _compare(log: Log, tick: LoggedTick, again: TickPayloads) -> None:
    found = between(tick.number, tick.payloads, again)
    if found is not None:
        raise Mismatch(log, found)
