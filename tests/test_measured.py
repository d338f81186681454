"""Robots that find the optimum by counting beacons: nobody on their side evaluates or is told the channel."""

import subprocess
import sys

import numpy as np
import pytest

from agents import contacts, counting, reception
from agents.reception import POOLED, SUMS, Reception
from console import inprocess
from fes import objective
from fes.arrays import Floats
from fes.config import ObjectiveConfig
from fes.edges import Edges
from fes.sensing import Observations
from tests import layouts
from tests.loop import load
from world.optimum import optimal_separation
from world.scenario import Scenario

SEEDS = range(8)

CODE = """
import sys
import numpy as np
from agents import crew, process
from fes.config import AgentConfig, FormationConfig, ObjectiveConfig, SeekingConfig
config = AgentConfig(dt=0.02, seed=1, objective=ObjectiveConfig(), formation=FormationConfig(),
                     seeking=SeekingConfig(index="measured", dither_frequency=0.3), channel=None)
crew.start(crew.assemble(config, np.arange(2)))
print(*sorted(sys.modules))
"""


def follow(scenario: Scenario) -> tuple[Floats, float, float]:
    """Mean estimate at each tick [t] [m], largest disagreement from 60 s on [m], r* [m]."""
    mean, apart = [], []
    for tick in inprocess.ticks(scenario):
        links, estimates = tick.said.links, tick.said.estimates
        mean.append(estimates.mean() if len(links) else np.nan)
        both = estimates[links.mutual] - estimates[links.reverse[links.mutual]]
        apart.append(np.abs(both).sum())
    late = round(60.0 / scenario.run.dt)
    return np.array(mean), max(apart[late:]), optimal_separation(scenario.objective, scenario.channel)


def time_to_one_meter(error: Floats, dt: float) -> float:
    """First time [s] from which |error| stays below 1 m for 10 s."""
    held = 0
    for tick, inside in enumerate(np.abs(error) < 1.0):
        held = held + 1 if inside else 0
        if held >= round(10.0 / dt):
            return (tick + 1 - held) * dt
    return float("inf")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "median", "bias", "rmse"),
    [("measured.toml", 12.0, 0.2, 0.35), ("measured-coverage.toml", 17.0, 0.5, 0.5)],
)
def test_counting_beacons_finds_the_optimum(name: str, median: float, bias: float, rmse: float) -> None:
    times, errors, disagreements = [], [], []
    for seed in SEEDS:
        scenario = load(name, run__seed=seed)
        mean, disagreement, optimal = follow(scenario)
        times.append(time_to_one_meter(mean - optimal, scenario.run.dt))
        errors.append((mean - optimal)[round(60.0 / scenario.run.dt) :])
        disagreements.append(disagreement)
    late = np.array(errors)
    assert np.median(times) <= median
    assert abs(late.mean()) <= bias
    assert np.sqrt(np.mean(late**2)) <= rmse
    assert max(disagreements) < 0.5


def test_the_fit_finds_level_and_slope_of_a_channel_of_its_family() -> None:
    """Samples of p = exp(-c r^nu) at separations about rho_0, without exchange and without aging."""
    rng, c, nu, scale = np.random.default_rng(4), 3e-7, 3.0, 75.0
    known = reception.nothing(POOLED, 1)
    for _ in range(4000):
        r = rng.uniform(60.0, 90.0, 26)
        decoded = rng.random(26) < np.exp(-c * r**nu)
        known = reception.learn(known, np.zeros(26, dtype=np.int64), r, decoded, scale)
    # 104,000 samples at p = 0.88 (Fisher information of the two): 2 sigma are 0.02 and 0.15
    assert known.level[0] == pytest.approx(np.log(c * scale**nu), abs=0.02)
    assert known.exponent[0] == pytest.approx(nu, abs=0.15)


def test_misses_are_learnt_from_the_gap_at_separations_in_between() -> None:
    """A peer moves away by 1 m a tick; of ticks 0 to 4 only the beacons of 0 and 4 decode."""
    near = layouts.edges([0], [(0, 1)])
    now, ids = contacts.nobody(near.ids), np.array([1])
    found = []
    for tick in range(1, 6):
        said = layouts.silent_beacons(tick - 1, ids, layouts.poses([(60.0 + tick - 1, 0.0)]))
        before, code = now, 2 if tick in (1, 5) else 1
        sensed = Observations(tick, layouts.poses([(0.0, 0.0)]), near, np.array([code], dtype=np.uint8))
        now = contacts.update(before, sensed, layouts.poses([(0.0, 0.0)]), said, 50)
        at, separation, decoded = counting.slots(before, now, tick, np.ones(1, dtype=np.bool_))
        found.append((at.tolist(), separation.tolist(), decoded.tolist()))
    assert found[0] == ([0], [60.0], [True])
    assert found[1:4] == [([], [], [])] * 3
    assert found[4] == ([0] * 4, [64.0, 61.0, 62.0, 63.0], [True, False, False, False])


def test_mixing_keeps_what_all_agree_on_and_ages_it() -> None:
    everybody = Edges(np.arange(3), np.array([0, 0, 1, 1, 2, 2]), np.array([1, 2, 0, 2, 0, 1]))
    sums = np.tile(np.arange(1.0, SUMS + 1.0), (3, 1))
    before = Reception(POOLED, sums, np.zeros(3), np.ones(3))
    mixed = reception.mix(before, everybody, np.ones(6, dtype=np.bool_), sums[everybody.peers])
    after = reception.fade(mixed, 0.02)
    faded = np.array([np.exp(-0.02 / 6.0)] * 3 + [np.exp(-0.02 / 120.0)] * 2)
    np.testing.assert_allclose(after.sums, sums * faded, rtol=1e-14)  # roundings


def test_the_curvature_of_the_wish_is_the_derivative_of_its_slope() -> None:
    r, h = np.linspace(20.0, 145.0, 60), 1e-4
    for wish in (ObjectiveConfig(), ObjectiveConfig(minimum_separation=100.0, shape_exponent=3.0)):
        rise = objective.log_preference_slope(r + h, wish) - objective.log_preference_slope(r - h, wish)
        # central differences: h^2 times the third derivative, and 1e-16/h of rounding
        np.testing.assert_allclose(objective.log_preference_curvature(r, wish), rise / (2.0 * h), atol=1e-10)


def test_a_crew_that_measures_never_loads_the_formula_nor_is_told_the_channel() -> None:
    loaded = subprocess.run([sys.executable, "-c", CODE], capture_output=True, text=True, timeout=60, check=True)
    assert "agents.reception" in loaded.stdout.split()
    assert not {"agents.oracle", "fes.outage"} & set(loaded.stdout.split())
