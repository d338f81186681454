"""Collector of a run's metrics, tick by tick, from the truth and from the robots' telemetry."""

import logging
import math
from dataclasses import fields, replace
from typing import Any

import numpy as np

from fes.arithmetic import sums
from fes.arrays import masks
from fes.arrays.edges import Edges
from fes.arrays.types import Bools, Floats, Ints, read_only
from fes.errors import FesError
from fes.extension import crew_laws, registry
from fes.extension.kinds import METRIC
from fes.model import counts, objective
from fes.model.seeking import MAX_TICKS
from fes.model.sensing import Telemetry
from world.config import events
from world.config.radio import RadioConfig
from world.config.scenario import Scenario
from world.metrics import deadlines, link_errors
from world.metrics.link_errors import LinkErrors
from world.metrics.period_average import PeriodAverage
from world.metrics.team import target
from world.metrics.team.progress import TeamProgress
from world.metrics.tick_truth import TickTruth
from world.metrics.tracking import TeamErrors, Tracking
from world.simulation import neighbor_list, reception
from world.simulation.channel import Radio
from world.simulation.truth import State

_logger = logging.getLogger("metrics")


class MetricsCollector:
    """Metrics of a run up to the last tick; call `add` once per tick, in order."""

    state: State
    """State at the last tick."""
    telemetry: Telemetry
    """Telemetry at the last tick."""
    separation: Floats
    """Separation of each of `telemetry.links.undirected` at the last tick [u] [m].

    With a physical dither, the mean over a dither period if the link is old enough.
    """

    def __init__(self, scenario: Scenario) -> None:
        self.scenario = scenario
        self.link_errors = LinkErrors(scenario.run.dt)
        self.tracking = Tracking(scenario.run.dt)
        self.optimal = math.nan
        """r* of the channel at the last tick [m]; of a configuration, the best link length of its shape (r_beta)."""
        self._period_average = PeriodAverage(dither_period(scenario))
        self._channel: RadioConfig | None = None
        self._present: Bools | None = None
        self._is_configured = scenario.formation.configuration != "none"
        self.deadlines = deadlines.no_deadlines(scenario.robots.number) if scenario.run.clock == "live" else None
        """Deadlines of the live clock; None in lockstep."""
        self.unscheduled_absences = 0
        """Number of robot-ticks without the robot, although it was present by schedule."""
        self.smallest_separation = math.inf
        """Smallest separation of two robots present at any tick so far [m]; infinite without two of them."""
        self.is_model_free: bool | None = None
        """False if a robot was told the channel, True if none was; None where that is not known."""
        self.team = TeamProgress(scenario) if scenario.has_team_index else None
        """Progress of the team index; None where it is not asked for."""
        context = reception.context(scenario)
        self.extensions = {metric.key: registry.create(METRIC, metric.choice, context) for metric in scenario.metric}
        """Metrics of the scenario, by name."""
        self._schedule = scenario.participation
        self._scheduled = np.ones(scenario.robots.number, dtype=np.bool_)

    @np.errstate(over="ignore", invalid="ignore")  # a run may diverge: its errors are then infinite
    def add(self, state: State, twists: Floats, telemetry: Telemetry, command_ticks: Ints | None = None) -> None:
        """Add a tick: the state, the twists [n, 2] that the bodies hold from it on, and the robots' telemetry.

        With the live clock, `command_ticks` [n] is the tick of the command that each robot follows, -1 for none.
        """
        if self.deadlines is not None and command_ticks is not None:
            self.deadlines.add(state.tick, state.present, command_ticks)
        self._add_absences(state)
        present = state.present
        self.smallest_separation = neighbor_list.smallest(
            state.proximity, state.poses, present, self.smallest_separation
        )
        truth = self._tick_truth(state, twists, telemetry)
        self.link_errors.add(truth)
        self.tracking.add(state.tick, truth.optimal, truth.is_changed, self._team_errors(truth))
        mean, now = truth.mean_separation, truth.separation
        self.separation = now if mean is now else np.where(np.isfinite(mean), mean, now)
        if telemetry.is_model_free is not None:
            self.is_model_free = telemetry.is_model_free and self.is_model_free is not False
        self.state, self.telemetry = state, telemetry
        if self.team is not None:
            self.team.add(state)
        if self.extensions:
            seen = _read_only(truth)
            for metric in self.extensions.values():  # the last step: after an error the tick is complete without it
                metric.add(seen)

    def shared(self) -> dict[str, Any]:
        """Quantities of the last tick that summary and report share, by their name in the summary."""
        errors = self.link_errors.errors
        return {
            "optimal_separation": self.optimal,
            "disagreement": errors["disagreement"],
            "estimate_error_max": errors["estimate_error"],
            "beacons_sent": self.state.sent,
            "beacons_decoded": self.state.decoded,
        }

    def team_numbers(self) -> dict[str, dict[str, float | None]]:
        """The numbers of each metric of the scenario; none of one that fails, and a warning says why."""
        numbers: dict[str, dict[str, float | None]] = {}
        for name, metric in self.extensions.items():
            try:
                numbers[name] = dict(metric.result())
            except FesError as error:  # the other results of a long run are worth keeping
                _logger.warning("%s; the summary has none of its numbers", error)
                numbers[name] = {}
        return numbers

    def _tick_truth(self, state: State, twists: Floats, telemetry: Telemetry) -> TickTruth:
        is_changed = state.channel is not self._channel and state.channel != self._channel
        is_resized = self._is_configured and state.present is not self._present
        if is_changed or is_resized:
            self._channel, self._present = state.channel, state.present
            number = int(np.count_nonzero(state.present))
            self.optimal = target.sought_separation(self.scenario, state.channel, number)
        separation = link_errors.link_separations(telemetry.links, state.poses)
        self._period_average.add(telemetry.links, separation)
        return TickTruth(state, twists, telemetry, separation, self._period_average.mean, self.optimal, is_changed)

    def _team_errors(self, truth: TickTruth) -> TeamErrors:
        """Errors over all links; rms and index are NaN where the tracking does not need them."""
        links, optimal = truth.telemetry.links, truth.optimal
        rms = index = math.nan
        error = self.link_errors.errors["estimate"] - optimal
        if len(links) and self.tracking.is_settled(truth.state.tick, truth.is_changed):
            mean = truth.mean_separation
            of_old_links = mean[np.isfinite(mean)]  # a younger link has no mean over a period yet
            rms = math.sqrt(sums.mean(np.square(of_old_links - optimal)))
            preference = objective.preference(truth.separation, self.scenario.objective)
            index = sums.mean(preference * link_reception(truth.state.radio, links))
        return TeamErrors(error, self.link_errors.errors["disagreement"], rms, index)

    def _add_absences(self, state: State) -> None:
        change = self._schedule.get(state.tick)
        if change is not None:
            self._scheduled = events.participating(self._scheduled, change)
        if not masks.is_full(state.present):
            self.unscheduled_absences += int(np.count_nonzero(self._scheduled & ~state.present))


def _read_only(truth: TickTruth) -> TickTruth:
    """The same truth for metrics of others: they cannot write to what the run still needs."""
    radio = replace(truth.state.radio, **_views(_values(truth.state.radio)))
    state = replace(truth.state, **_views(_values(truth.state)), radio=radio)
    telemetry = truth.telemetry._replace(**_views(truth.telemetry._asdict()))
    return truth._replace(**_views(truth._asdict()), state=state, telemetry=telemetry)


def _values(instance: Any) -> dict[str, Any]:
    """The fields of a data class by name; the core makes some of them only when they are read."""
    return {field.name: getattr(instance, field.name) for field in fields(instance)}


def _views(values: dict[str, Any]) -> dict[str, Any]:
    """Read-only views of the arrays among these values."""
    return {name: read_only(value) for name, value in values.items() if isinstance(value, np.ndarray)}


def link_reception(radio: Radio, links: Edges) -> Floats:
    """True reception probability of each of `links.undirected` [u], mean over directions; NaN without a contact."""
    if not len(radio.edges):
        return np.full(len(links.undirected), np.nan)
    positions = links.after(radio.edges).positions[links.undirected]
    backward = radio.edges.reverse.take(positions)
    mean = 0.5 * (radio.probability.take(positions) + radio.probability.take(backward))
    return np.where(positions >= 0, mean, np.nan)


def dither_period(scenario: Scenario) -> int:
    """Ticks over which separations are averaged: the period of a physical dither, else 1."""
    period = crew_laws.physical_period(scenario.seeking)
    if period is None:
        return 1
    try:
        counts.check("the law's physical_period / run.dt", period, scenario.run.dt, MAX_TICKS)
    except ValueError as error:
        raise FesError(f"seeking: {error}") from None
    return counts.ticks_of(period, scenario.run.dt)
