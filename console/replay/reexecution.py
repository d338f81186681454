"""A second execution of a recorded run: the world from recorded Commands, robots from Observations and Beacons.

Every result is compared with the log, to the bit.
"""

from collections.abc import Callable, Collection, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np

from agents.control import crew, transmitter
from agents.runtime import marshalling as agent_marshalling
from agents.runtime import reception
from agents.runtime.marshalling import MessageAssembler
from agents.runtime.reception import Receiver
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
"""Bound beyond which a recorded wall-clock time is ignored [s]."""

T = TypeVar("T", Observation, Beacon, Command)


class Mismatch(FesError):
    """A second execution differs from the log. A note shows whether another processor may be the cause."""

    def __init__(self, log: Log, difference: Difference | str) -> None:
        super().__init__(
            difference if isinstance(difference, str) else difference.describe("in the log", "executed again")
        )
        self.add_note(f"recorded with {fingerprint.text(log.arithmetic)}; executed with {fingerprint.text()}")


@dataclass(frozen=True, eq=False)
class ReplayedTick:
    """One tick of the world's second execution."""

    recorded: LoggedTick
    state: State
    twists: Floats
    """[n, 2] [m/s, rad/s]"""
    telemetry: Telemetry
    command_ticks: Ints
    """Tick of the command that each robot follows [n], -1 for none."""


def world(log: Log) -> Iterator[ReplayedTick]:
    """Every tick of a log, the world moved by the recorded Commands.

    Raises Mismatch where an Observation differs, and FesError where the log is damaged.
    """
    simulation = truth.create(log.scenario)
    state, batch = truth.start(simulation), CommandBatch(simulation.ids)
    previous: ReplayedTick | None = None
    live = log.scenario.run.clock == "live"
    for tick in log.ticks():
        if previous is not None:  # not after the last recorded tick: its successor is unknown
            state = truth.step(simulation, previous.state, previous.twists)
        _check_schedule(log, tick)
        channel = state.channel
        for path, value in tick.changes:
            channel = events.changed(channel, {path: value}, log.scenario.run.dt)
        if channel is not state.channel:
            state = replace(state, channel=channel)
        for robots in tick.attended:
            state = truth.attend(state, np.isin(simulation.ids, robots))
        sensed = world_marshalling.observations(truth.observe(state), state.present, state.since)
        _compare(log, tick, tick.payloads._replace(observations=sensed))
        commands: list[Command | None] = [None] * len(simulation.ids)
        participating = np.flatnonzero(state.present).tolist()
        if live:  # a robot without a command stops
            participating = [robot for robot in participating if tick.payloads.commands[robot]]
        decoded = _decoded(tick, messages.decode_command, tick.payloads.commands, participating, held=live)
        for robot, command in zip(participating, decoded, strict=True):
            commands[robot] = command
        twists, telemetry = batch.read(commands)
        command_ticks = np.array([-1 if command is None else command.tick for command in commands])
        previous = ReplayedTick(tick, state, twists, telemetry, command_ticks)
        yield previous


def accounted(log: Log) -> Iterator[tuple[ReplayedTick, MetricsCollector]]:
    """Every tick of `world`, with the metrics up to it.

    Raises Mismatch if a Report or, after the last tick, the summary differs, and FesError if a Report is missing.
    """
    metrics, elapsed, period = MetricsCollector(log.scenario), 0.0, report_period(log.scenario)
    for moment in world(log):
        metrics.add(moment.state, moment.twists, moment.telemetry, moment.command_ticks)
        number, recorded = moment.recorded.number, moment.recorded.report
        if recorded is not None:
            elapsed = recorded.elapsed
            _check_report(log, metrics, recorded)
        elif number % period == 0 or number == log.scenario.ticks - 1:
            raise FesError(f"tick {number}: the Report that is due is not in the log")
        yield moment, metrics
    _check_summary(log, summary(log, metrics, elapsed))


def summary(log: Log, metrics: MetricsCollector, elapsed: float = 0.0) -> dict[str, Any]:
    """The summary of `metrics`; its wall-clock time is that of the log, or `elapsed` [s].

    Raises FesError if the deadlines in the log's summary cannot be read.
    """
    wall = (log.summary or {}).get("wall_s")
    wall = float(wall) if isinstance(wall, int | float) and abs(wall) < YEARS else elapsed
    deadlines = (log.summary or {}).get("deadlines")
    if metrics.deadlines is not None and isinstance(deadlines, dict):  # lateness is not in the messages
        try:
            metrics.deadlines.late = np.array(deadlines.get("late"), dtype=np.int64)
            metrics.deadlines.slipped = float(deadlines.get("slipped_s", 0.0))
        except (TypeError, ValueError, OverflowError):
            raise FesError(f"{log.path}: the deadlines in its summary cannot be read") from None
    summarized: dict[str, Any] = strict_json.loads(strict_json.dumps(summarize(metrics, log.name, log.backend, wall)))
    return {**summarized, "arithmetic": dict(log.arithmetic)}


class ReplayedRobots:
    """Some robots of a log, executed again tick by tick by their own code."""

    def __init__(self, log: Log, ids: Collection[int]) -> None:
        if log.scenario.run.clock == "live":
            raise FesError(
                f"{log.path} is of the live clock: the log does not show which inputs a robot received in time"
            )
        robots = np.array(sorted(ids), dtype=np.int64)
        self._crew = crew.create(agent_config(log.scenario), robots)
        self._state = crew.start(self._crew)
        self._stack, self._receiver = MessageAssembler(robots), Receiver()
        self._robots = robots.tolist()
        self._log = log
        self._before: LoggedTick | None = None

    def step(self, tick: LoggedTick) -> None:
        """Execute a tick, and compare each Beacon and Command; raises Mismatch, or FesError for an incomplete log."""
        sensing = [robot for robot in self._robots if tick.payloads.observations[robot]]
        sensed = dict(
            zip(
                sensing, _decoded(tick, messages.decode_observation, tick.payloads.observations, sensing), strict=True
            )
        )
        restarted = np.array([robot in sensed and sensed[robot].since == tick.number for robot in self._robots])
        if restarted.any():
            self._state = crew.forget(self._crew, self._state, restarted)
        observations = self._stack.observations(
            [sensed.get(robot) or _absent(tick.number, robot) for robot in self._robots]
        )
        received = []
        if self._before is not None:
            payloads = self._before.payloads.beacons
            peers = [peer for peer in np.unique(observations.in_range.peers).tolist() if payloads[peer]]
            received = _decoded(self._before, messages.decode_beacon, payloads, peers)
        if reception.missing(observations, [beacon.robot for beacon in received]):
            raise FesError(f"tick {tick.number - 1}: a Beacon that was decoded is not in the log")
        beacons = self._stack.beacons(tick.number - 1, received)
        arrived = self._receiver.receive(observations, beacons, self._state.contacts.edges)
        self._state, sent, twists, telemetry = crew.step(self._crew, self._state, observations.sensed, arrived)
        telemetry = replace(telemetry, is_model_free=_stated(tick, sensing))
        broken = transmitter.damaging(self._crew.transmitters, tick.number)
        for robot, encoded, command in agent_marshalling.encode_tick(sent, twists, telemetry):
            if robot not in sensed:
                continue
            beacon = b"" if robot in broken else encoded
            recorded = tick.payloads.beacons[robot], tick.payloads.commands[robot]
            for message, logged, computed in zip(("Beacon", "Command"), recorded, (beacon, command), strict=True):
                if logged != computed:
                    raise Mismatch(self._log, of_payloads(tick.number, message, robot, logged, computed))
        self._before = tick


def _stated(tick: LoggedTick, robots: list[int]) -> bool | None:
    """The statement of the recorded commands about their processes: it cannot be computed again."""
    for payload in filter(None, (tick.payloads.commands[robot] for robot in robots)):
        with suppress(MessageError):
            return messages.decode_command(payload).is_model_free
    return None


def _absent(tick: int, robot: int) -> Observation:
    """Observation for an absent robot; its state is discarded when the robot rejoins."""
    nothing = np.zeros(0, dtype=np.int64)
    return Observation(tick, robot, (0.0, 0.0, 0.0), nothing, nothing.astype(np.uint8), over=False, since=0)


def report(metrics: MetricsCollector, like: Report) -> Report:
    """The Report of the last tick of `metrics`, with the fields of the machine from `like`."""
    if metrics.deadlines is not None and len(like.late):
        metrics.deadlines.late = like.late
    return report_builder.build(metrics, like.scenario, like.alive, like.elapsed, like.ticks_per_s)


def _check_report(log: Log, metrics: MetricsCollector, recorded: Report) -> None:
    """Raise Mismatch unless the Report of the last tick of `metrics` is the recorded one."""
    difference = of_reports(recorded, report(metrics, recorded))
    if difference is not None:
        raise Mismatch(log, difference)


def _check_summary(log: Log, again: dict[str, Any]) -> None:
    """Raise Mismatch if the log has a summary that differs from `again`."""
    if log.summary is None:
        return
    for key in [*log.summary, *(key for key in again if key not in log.summary)]:
        logged, computed = (
            strict_json.dumps(summarized[key]) if key in summarized else None for summarized in (log.summary, again)
        )
        if logged != computed:
            values = [
                repr(summarized[key]) if key in summarized else "missing" for summarized in (log.summary, again)
            ]
            raise Mismatch(log, f"summary: {key} is {values[0]} in the log and {values[1]} executed again")


def _check_schedule(log: Log, tick: LoggedTick) -> None:
    """Raise Mismatch unless the settings recorded at this tick are those that the scenario schedules."""
    planned = list(log.scenario.changes.get(tick.number, {}).items())
    if tick.scheduled != planned:
        raise Mismatch(log, Difference(tick.number, "events", None, "what was scheduled", tick.scheduled, planned))


def _decoded(
    tick: LoggedTick, decode: Callable[[bytes], T], payloads: list[bytes], robots: Iterable[int], held: bool = False
) -> list[T]:
    """The messages of some robots at a tick; raises FesError where one is missing, damaged or of another robot.

    With `held` they may be of earlier ticks.
    """
    decoded = []
    for robot in robots:
        try:
            message = decode(payloads[robot])
            name = type(message).__name__
            is_due = message.tick <= tick.number if held else message.tick == tick.number
            if not is_due or message.robot != robot:
                raise MessageError(name, "is of another tick or robot", f"tick {message.tick}, robot {message.robot}")
            peers = message.in_range if isinstance(message, Observation) else message.links
            if len(peers) and not 0 <= peers.min() <= peers.max() < len(payloads):
                raise MessageError(name, f"names a robot that is not one of {len(payloads)}", str(peers.tolist()))
        except MessageError as error:
            raise FesError(f"tick {tick.number}, robot {robot}: {error}") from None
        decoded.append(message)
    return decoded


def _compare(log: Log, tick: LoggedTick, computed: TickPayloads) -> None:
    difference = between(tick.number, tick.payloads, computed)
    if difference is not None:
        raise Mismatch(log, difference)
