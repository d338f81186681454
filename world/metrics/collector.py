"""What a run achieved, added up tick by tick from the truth and from what the robots say of themselves."""

import math

import numpy as np

from fes.arrays.edges import Edges
from fes.arrays.types import Floats, Ints
from fes.model import counts, objective
from fes.model.sensing import Telemetry
from world.config import events
from world.config.radio import RadioConfig
from world.config.scenario import Scenario
from world.metrics import deadlines, link_errors
from world.metrics.link_errors import LinkErrors
from world.metrics.optimum import optimal_separation
from world.metrics.period_average import PeriodAverage
from world.metrics.tracking import Tracking
from world.simulation.channel import Radio
from world.simulation.truth import State


class MetricsCollector:
    """Sums up a run; `add` is called once for each tick, in order."""

    state: State
    """At the last tick."""
    telemetry: Telemetry
    """At the last tick."""
    separation: Floats
    """At the last tick, of each of `telemetry.links.undirected` [u] [m]; averaged over a dither period if the
    formation breathes and the link has stood for one."""

    def __init__(self, scenario: Scenario) -> None:
        self.scenario = scenario
        self.link_errors = LinkErrors(scenario.run.dt)
        self.tracking = Tracking(scenario.run.dt)
        self.optimal = math.nan
        """r* of the channel at the last tick [m]."""
        self._period_average = PeriodAverage(dither_period(scenario))
        self._channel: RadioConfig | None = None
        self.deadlines = deadlines.no_deadlines(scenario.robots.number) if scenario.run.clock == "live" else None
        """Where the clock is live."""
        self.unscheduled_absences = 0
        """Robot-ticks in which a robot took no part although the schedule had it present."""
        self._attendance = scenario.attendance
        self._scheduled = np.ones(scenario.robots.number, dtype=np.bool_)

    @np.errstate(over="ignore", invalid="ignore")  # a run may diverge: its errors are then infinite
    def add(self, state: State, twists: Floats, telemetry: Telemetry, spoken: Ints | None = None) -> None:
        """Add a tick: the state, the twists [n, 2] of the robots in it, and what they said.

        Where the clock is live, `spoken` [n] is the tick of the command that each follows, -1 for none.
        """
        if self.deadlines is not None and spoken is not None:
            self.deadlines.add(state.tick, state.present, spoken)
        self._add_absences(state)
        changed = state.channel is not self._channel and state.channel != self._channel
        if changed:
            self._channel = state.channel
            self.optimal = optimal_separation(self.scenario.objective, state.channel)
        self.state, self.telemetry = state, telemetry
        links, estimates = telemetry.links, telemetry.estimates
        now = link_errors.separations(state.poses, *link_errors.ends(links))
        self._period_average.add(links, now)
        mean = self._period_average.mean
        self.link_errors.add(
            state.poses, twists, state.proximity, state.present, state.sent > 0, telemetry, mean, self.optimal
        )
        self.separation = np.where(np.isfinite(mean), mean, now)
        error = rms = index = math.nan
        if len(links):
            error = float(estimates.sum()) / len(links) - self.optimal
        if len(links) and self.tracking.settled(state.tick, changed):
            old = mean[np.isfinite(mean)]  # links that have stood for a period
            rms = math.sqrt(float(np.mean((old - self.optimal) ** 2))) if len(old) else math.nan
            wish = objective.preference(now, self.scenario.objective)
            index = float(np.mean(wish * link_reception(state.radio, links)))
        apart = self.link_errors.errors["disagreement"]
        self.tracking.add(state.tick, self.optimal, changed, error, apart, rms, index)

    def _add_absences(self, state: State) -> None:
        planned = self._attendance.get(state.tick)
        if planned is not None:
            self._scheduled = events.attended(self._scheduled, planned)
        if not state.present.all():
            self.unscheduled_absences += int(np.count_nonzero(self._scheduled & ~state.present))


def link_reception(radio: Radio, links: Edges) -> Floats:
    """The true reception probability of each of `links.undirected` [u], mean of both ways; NaN out of contact."""
    if not len(radio.edges):
        return np.full(len(links.undirected), np.nan)
    at = links.after(radio.edges).positions[links.undirected]
    both = 0.5 * (radio.probability.take(at) + radio.probability.take(radio.edges.reverse.take(at)))
    return np.where(at >= 0, both, np.nan)


def dither_period(scenario: Scenario) -> int:
    """Ticks over which separations are averaged: the period of a physical dither, else 1."""
    if scenario.seeking.index == "oracle":
        return 1
    return counts.ticks_of(2.0 * math.pi / scenario.seeking.dither_frequency, scenario.run.dt)
