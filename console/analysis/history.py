"""A run as time series, for figures; from its log, or from its scenario, which determines it."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from console.analysis import run_events
from console.analysis.run_events import Event
from console.backends import inprocess
from console.replay import reexecution
from console.replay.log import Log
from console.terminal import counting
from console.terminal.counting import Watch
from fes.arrays.edges import Edges
from fes.arrays.types import Bools, Floats, Ints
from fes.model.sensing import Telemetry
from world.config.scenario import Scenario
from world.metrics import graphs, link_errors, report_builder
from world.metrics.collector import MetricsCollector, dither_period
from world.simulation.truth import State


@dataclass(frozen=True, eq=False)
class History:
    """Time series of a run; sums are over the links in use at each tick."""

    name: str
    """Name of the scenario."""
    scenario: Scenario
    time: Floats
    """[t] [s]"""
    poses: Floats
    """[t, n, 3] [m, m, rad; world frame]"""
    links: list[Edges]
    """Links in use at each tick, in both directions [t]."""
    outage: list[Floats]
    """True outage of each link in use at each tick, both directions averaged [t][u] [1]; NaN if unknown."""
    present: Bools
    """True for each robot that takes part at each tick [t, n]."""
    disagreement: Floats
    """Sum of |r_ij - r_ji| over links [t] [m]; NaN before the first link."""
    estimate_error: Floats
    """Sum of |r_ij - r*| over both ends of all links [t] [m]."""
    estimate_error_max: Floats
    """Largest |r_ij - r*| over both ends of all links [t] [m]; NaN without a link."""
    separation_error: Floats
    """Largest |separation - r*| [t] [m]; averaged over a dither period once it is complete, as in the summary."""
    optimal: float
    """r* [m]."""
    digest: str
    averaged: bool
    """True if the dither moves the formation, so that separations are averaged over a dither period."""
    team: Floats
    """Team index and its target at each tick [2, t] [1], computed every 0.1 s and held in between; [2, 0] for a run
    without them."""
    events: list[Event]
    """Changes of the channel and of the robots during the run, in order."""

    @property
    def cutting(self) -> Ints:
        """Robots whose loss would cut the links at the last tick [k]; empty without a team index."""
        return cutting_at(self, len(self.time) - 1)

    @property
    def optimum(self) -> str:
        """Symbol of the separation that the team seeks, as a formula: r_beta of a configuration, else r*."""
        return r"r_\beta" if self.scenario.formation.configuration != "none" else "r^*"


class Moment(Protocol):
    """One tick: truth, commands and telemetry."""

    @property
    def state(self) -> State:
        """True state."""

    @property
    def twists(self) -> Floats:
        """Commanded twists [n, 2] [m/s, rad/s]."""

    @property
    def telemetry(self) -> Telemetry:
        """Telemetry of the robots."""


def follow(scenario: Scenario, name: str = "", watch: Watch = counting.ignore) -> History:
    """Run a scenario in process, and return its history; `watch` is called with the completed ticks."""
    metrics = MetricsCollector(scenario)

    def accounted() -> Iterator[tuple[Moment, MetricsCollector]]:
        for tick in inprocess.ticks(scenario):
            metrics.add(tick.state, tick.twists, tick.telemetry)
            yield tick, metrics

    return gather(scenario, name, accounted(), watch)


def recorded(log: Log, watch: Watch = counting.ignore) -> History:
    """The history of a recorded run, as `follow`.

    Reports and summary are compared where `viewed` does, the digest included.
    """
    return gather(log.scenario, log.name, reexecution.viewed(log), watch)


def gather(
    scenario: Scenario,
    name: str,
    moments: Iterable[tuple[Moment, MetricsCollector]],
    watch: Watch = counting.ignore,
) -> History:
    """The history of at least one tick, each with the metrics up to it."""
    last = MetricsCollector(scenario)
    poses, links, losses, present, rows, team = [], [], [], [], [], []
    channels = []
    for tick, metrics in moments:
        last = metrics
        telemetry = tick.telemetry
        poses.append(tick.state.poses)
        watch(len(poses))
        links.append(telemetry.links)
        losses.append(report_builder.link_outage(metrics))
        present.append(tick.state.present)
        channels.append(tick.state.channel)
        total = float(np.abs(telemetry.estimates - metrics.optimal).sum()) if len(telemetry.links) else np.nan
        largest = float(np.abs(metrics.separation - metrics.optimal).max()) if len(links[-1]) else np.nan
        errors = metrics.link_errors.errors
        rows.append((errors["disagreement"], total, errors["estimate_error"], largest))
        if metrics.team is not None:
            team.append((metrics.team.latest.team_index, metrics.team.latest.target))
    series = np.array(rows).T
    time = scenario.run.dt * np.arange(len(poses), dtype=np.float64)
    return History(
        name,
        scenario,
        time,
        np.array(poses),
        links,
        losses,
        np.array(present),
        series[0],
        series[1],
        series[2],
        series[3],
        last.optimal,
        last.link_errors.digest.text(),
        dither_period(scenario) > 1,
        np.array(team).reshape(-1, 2).T,
        run_events.events(scenario, channels, present),
    )


def ends_at(history: History, tick: int) -> Floats:
    """Both ends of each link in use at a tick [l, 2, 2] [m; world frame]."""
    a, b = link_errors.ends(history.links[tick])
    positions = history.poses[tick, :, :2]
    return np.stack([positions[a], positions[b]], axis=1)


def cutting_at(history: History, tick: int) -> Ints:
    """Robots present whose loss would cut the links in use at a tick [k]; empty without a team index."""
    if not history.team.size:
        return np.zeros(0, dtype=np.int64)
    a, b = link_errors.ends(history.links[tick])
    present = history.present[tick]
    both = present[a] & present[b]
    return graphs.cut_rows(len(present), a[both], b[both])
