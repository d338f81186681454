"""A run as time series, for figures. A run is a function of its scenario, so it need not have been recorded."""

from dataclasses import dataclass

import numpy as np

from console import inprocess
from fes.arrays import Floats
from fes.edges import Edges
from world import metrics
from world.account import Account
from world.scenario import Scenario


@dataclass(frozen=True, eq=False)
class History:
    """What happened in a run, tick by tick; sums are over the links in use at each tick."""

    time: Floats
    """[t] [s]"""
    poses: Floats
    """[t, n, 3] [m, m, rad; world frame]"""
    links: list[Edges]
    """Links in use at each tick, in both directions [t]."""
    disagreement: Floats
    """Sum of |r_ij - r_ji| over links [t] [m]; NaN before there are any."""
    estimate_error: Floats
    """Sum of |r_ij - r*| over both ends of all links [t] [m]."""
    separation_error: Floats
    """Largest |separation - r*| [t] [m]."""
    optimal: float
    """r* [m]."""
    digest: str


def follow(scenario: Scenario) -> History:
    """Run a scenario in process, and keep its history."""
    sums = Account(scenario)
    poses, links, rows = [], [], []
    for tick in inprocess.ticks(scenario):
        sums.add(tick.state, tick.twists, tick.telemetry)
        poses.append(tick.state.poses)
        links.append(tick.said.links)
        total = float(np.abs(tick.said.estimates - sums.optimal).sum()) if len(tick.said.links) else np.nan
        errors = sums.tally.errors
        rows.append((errors["disagreement"], total, errors["separation_error"]))
    series = np.array(rows).T
    time = scenario.run.dt * np.arange(len(poses), dtype=np.float64)
    return History(time, np.array(poses), links, series[0], series[1], series[2], sums.optimal, sums.tally.digest())


def ends_at(history: History, tick: int) -> Floats:
    """Both ends of each link in use at a tick [l, 2, 2] [m; world frame]."""
    a, b = metrics.ends(history.links[tick])
    positions = history.poses[tick, :, :2]
    return np.stack([positions[a], positions[b]], axis=1)
