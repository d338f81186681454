"""A second execution of a recorded run: the world from recorded Commands, robots from Observations and Beacons.

Every result is compared with the log, to the bit; only views of logs with another arithmetic do without.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np

from console.replay.difference import Difference, between, of_reports
from console.replay.log import Log
from console.replay.recorded import Mismatch, decoded, has_own_digits
from fes.arrays.types import Floats, Ints
from fes.errors import FesError
from fes.model.sensing import Telemetry
from fes.protocol import messages
from fes.protocol.messages import Beacon, Command, Observation
from fes.protocol.report import Report
from fes.recording.layout import TickPayloads
from fes.recording.ticks import LoggedTick
from fes.system import strict_json
from world.config import events
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


def world(log: Log, is_compared: bool = True) -> Iterator[ReplayedTick]:
    """Every tick of a log, the world moved by the recorded Commands.

    Raises Mismatch where an Observation differs, if it `is_compared`, and FesError where the log is damaged.
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
        if is_compared:
            sensed = world_marshalling.observations(truth.observe(state), state.present, state.since)
            _compare(log, tick, tick.payloads._replace(observations=sensed))
        commands: list[Command | None] = [None] * len(simulation.ids)
        participating = np.flatnonzero(state.present).tolist()
        if live:  # a robot without a command stops
            participating = [robot for robot in participating if tick.payloads.commands[robot]]
        answers = decoded(tick, messages.decode_command, tick.payloads.commands, participating, held=live)
        for robot, command in zip(participating, answers, strict=True):
            commands[robot] = command
        twists, telemetry = batch.read(commands)
        command_ticks = np.array([-1 if command is None else command.tick for command in commands])
        previous = ReplayedTick(tick, state, twists, telemetry, command_ticks)
        yield previous


def accounted(log: Log, is_compared: bool = True) -> Iterator[tuple[ReplayedTick, MetricsCollector]]:
    """Every tick of `world`, with the metrics up to it.

    Raises Mismatch if a Report or, after the last tick, the summary differs, and FesError if a Report is missing.
    Without a comparison it raises no Mismatch.
    """
    metrics, elapsed, period = MetricsCollector(log.scenario), 0.0, report_period(log.scenario)
    for moment in world(log, is_compared):
        metrics.add(moment.state, moment.twists, moment.telemetry, moment.command_ticks)
        number, recorded = moment.recorded.number, moment.recorded.report
        if recorded is not None:
            elapsed = recorded.elapsed
            if is_compared:
                _check_report(log, metrics, recorded)
        elif number % period == 0 or number == log.scenario.ticks - 1:
            raise FesError(f"tick {number}: the Report that is due is not in the log")
        yield moment, metrics
    if is_compared:
        _check_summary(log, summary(log, metrics, elapsed))


def viewed(log: Log) -> Iterator[tuple[ReplayedTick, MetricsCollector]]:
    """As `accounted`, for a view: compared only if the log has the arithmetic of this process (`other_digits`)."""
    return accounted(log, is_compared=has_own_digits(log))


def reports(log: Log) -> Iterator[Report]:
    """The Report of each tick; recorded Reports, and the summary at the end, are compared where `viewed` does."""
    latest = None
    for moment, metrics in viewed(log):
        latest = moment.recorded.report or latest
        if latest is not None:
            yield report(metrics, latest)


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


def _compare(log: Log, tick: LoggedTick, computed: TickPayloads) -> None:
    difference = between(tick.number, tick.payloads, computed)
    if difference is not None:
        raise Mismatch(log, difference)
