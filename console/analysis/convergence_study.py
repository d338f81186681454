"""Convergence of robots that count beacons: mean estimates over seeds, beside their lower bound."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from console.backends import stacked
from console.terminal import counting
from console.terminal.counting import Watch
from fes.arrays.types import Floats
from fes.model import objective, outage
from fes.model.table import Use
from world.config.scenario import Scenario, load
from world.metrics.optimum import optimal_separation

CHANGE = 60.0
"""Time at which the signal-to-noise ratio halves [s]."""

DURATION = 120.0
"""Simulated time of a run [s]."""

LINKS = 18
"""Directed links of ten robots in formation on the relative neighborhood graph."""

HALVED: dict[str, Any] = {
    "run.duration": DURATION,
    "event": [{"at": CHANGE, "set": {"channel.reference_snr": 5e6}}],
}
FED: dict[str, Any] = {
    "seeking.index": "sampled",
    "seeking.index_transform": "none",
    "seeking.index_gain": 44460.0,
    "seeking.law": "paper",
    "seeking.dither_amplitude": 0.2,
    "seeking.dither_frequency": 100.0,
}
"""The paper's (18), with its dither and the gain that its figures need, fed with samples."""


@dataclass(frozen=True, eq=False)
class Learning:
    """Errors of the mean estimates of several runs, tick by tick."""

    time: Floats
    """[t] [s]"""
    counted: Floats
    """Errors with the measured index [runs, t] [m]."""
    fed: Floats
    """Errors of (18) fed with samples [runs, t] [m]."""
    bound: Floats
    """Lower bound of the standard deviation of unbiased estimators, since the start or the change [t] [m]."""


class Study(NamedTuple):
    """The runs of the figure."""

    counted: list[Scenario]
    """Robots that count beacons."""
    fed: list[Scenario]
    """(18) fed with samples."""

    @property
    def ticks(self) -> int:
        """Ticks of all runs."""
        return sum(scenario.ticks for scenario in (*self.counted, *self.fed))


def study(configs: Path, runs: int = 20, fed: int = 3) -> Study:
    """`measured.toml` with a channel that changes over `runs` seeds, and (18) fed with samples over `fed`."""
    path = configs / "measured.toml"
    return Study(
        [load(path, {**HALVED, "run.seed": seed}) for seed in range(runs)],
        [load(path, {**HALVED, **FED, "run.seed": seed}) for seed in range(fed)],
    )


def learn(runs: Study, watch: Watch = counting.ignore) -> Learning:
    """The runs of a study; `watch` is called with their completed ticks."""
    counted, _ = runs
    first, second = counting.parts(watch, sum(scenario.ticks for scenario in counted), 0)
    errors, fed_errors = _errors(counted, first), _errors(runs.fed, second)
    time: Floats = counted[0].run.dt * np.arange(errors.shape[1], dtype=np.float64)
    since = np.where(time < CHANGE, time, time - CHANGE) + counted[0].run.dt
    return Learning(time, errors, fed_errors, np.sqrt(time_to_one_meter(counted[0], LINKS) / since))


def time_to_one_meter(scenario: Scenario, links: int, quality_weight: float = 1.0) -> float:
    """Lower bound T [s] of the time until an unbiased estimator of r* from `links` directed links has 1 m (1 sigma).

    The Cramer-Rao bound of a Bernoulli sample's slope at separations dithered about r*:
    T = (1 - p)/p / (f links (A^2/2) H^2), with f beacons per second and H = (ln J)''. With another `quality_weight`
    beta it is the bound of r_beta, and H = (ln c)''/beta + (ln q)''.
    """
    channel, objective_config = scenario.channel, scenario.objective
    best = np.array([optimal_separation(objective_config, channel, quality_weight)])
    p = float(outage.reception_probability(best, channel)[0])
    step = 1e-3
    slope_change = (
        outage.log_reception_slope(best + step, channel) - outage.log_reception_slope(best - step, channel)
    ) / step
    weight = np.array([quality_weight])
    preference = objective.log_preference_derivatives(best, objective_config, weight)[1]
    curvature = float((preference / weight + 0.5 * slope_change)[0])
    assert not isinstance(scenario.seeking, Use)
    excited = 0.5 * scenario.seeking.dither_amplitude**2
    return (1.0 - p) / p / (links / scenario.run.dt * excited * curvature**2)


def _errors(scenarios: list[Scenario], watch: Watch) -> Floats:
    """Mean estimate minus r* [runs, t] [m]; NaN before the first estimate."""
    rows, channel, best = [], None, math.nan
    for number, together in enumerate(stacked.ticks(scenarios), 1):
        now = together[0].state.channel  # all runs change at the same time
        if now is not channel:
            channel, best = now, optimal_separation(scenarios[0].objective, now)
        watch(number * len(scenarios))
        estimates_by_run = [tick.beacons.estimates for tick in together]
        rows.append(
            [float(estimates.mean()) - best if len(estimates) else math.nan for estimates in estimates_by_run]
        )
    return np.array(rows).T
