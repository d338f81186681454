"""The quality weight: with it, a law seeks the link length that is best for a whole shape, not for one link."""

from typing import Any

import numpy as np
import pytest

from agents.laws import packet_counting
from agents.laws.oracle import FormulaIndex, OracleSeeking
from agents.laws.packet_counting import POOLED, ReceptionFit
from agents.laws.perturbation import BASELINE, ESTIMATE, WEIGHT
from console.backends import inprocess
from fes.arrays.types import Floats
from fes.extension.neighborhood import Entry
from fes.model import objective, outage
from fes.model.config import ChannelConfig, ObjectiveConfig
from fes.model.seeking import OracleConfig
from tests.support import surroundings
from tests.support.loop import load

PATCH = (35 / 18) / 3.8
"""beta of the patch of ten robots."""

BEST = 71.2603
"""Link length at which c q^beta is largest on the channel of the paper's figures [m]."""

TEAM, CHANNEL = ObjectiveConfig(), ChannelConfig()
LOGISTIC = ChannelConfig(model="logistic")


def log_index(r: Floats, weight: float, channel: ChannelConfig) -> Floats:
    """ln c + beta ln q at `r` [m], as written."""
    coverage = np.log(1.0 - np.exp(-((r / 50.0) ** 4)))
    value: Floats = coverage + weight * (np.log(outage.reception_probability(r, channel)) - (r / 150.0) ** 4)
    return value


@pytest.mark.parametrize("channel", [CHANNEL, LOGISTIC], ids=["rayleigh", "logistic"])
@pytest.mark.parametrize("weight", [0.3, PATCH, 1.0, 2.037])
def test_the_weighted_index_is_c_q_to_the_beta(weight: float, channel: ChannelConfig) -> None:
    r, step = np.linspace(20.0, 140.0, 61), 1e-3
    weights = np.full(len(r), weight)
    log, plain = (FormulaIndex(TEAM, channel, transform, weights) for transform in ("log", "none"))
    divisor = max(1.0, weight)  # so that a large weight does not make the law unstable
    np.testing.assert_allclose(log(r), log_index(r, weight, channel) / divisor, rtol=1e-11)
    np.testing.assert_allclose(plain(r), np.exp(log_index(r, weight, channel)) / divisor, rtol=1e-11)
    for index in (log, plain):
        value, slope, bend = index.parabola(r)
        np.testing.assert_allclose(value, index(r), rtol=1e-12)
        np.testing.assert_allclose(slope, (index(r + step) - index(r - step)) / (2.0 * step), atol=1e-8)
        second = (index(r + step) - 2.0 * index(r) + index(r - step)) / (step * step)
        np.testing.assert_allclose(2.0 * bend, second, atol=1e-6)


def test_a_large_weight_leaves_the_law_stable() -> None:
    heavy = load("team-paper-start.toml", run__duration=20.0, objective__coverage_weight=0.02, expect=[])
    summary = inprocess.run(heavy, "heavy")
    assert summary["optimal_separation"] < 50.0
    assert summary["estimate_error_max"] < 1.0  # it falls at 0.2 /s; with a divisor of 1 it diverges


def test_the_weight_of_one_gives_the_digits_of_no_weight() -> None:
    r = np.linspace(1.0, 149.0, 149)
    for transform in ("log", "none"):
        with_weight = FormulaIndex(TEAM, CHANNEL, transform, np.ones(len(r)))
        without = FormulaIndex(TEAM, CHANNEL, transform)
        np.testing.assert_array_equal(np.stack(with_weight.parabola(r)), np.stack(without.parabola(r)))


def test_a_measured_estimate_rests_at_the_optimum_of_its_weight() -> None:
    # an exact fit of the channel: ln(-ln p) = level + 3 ln(r / 75)
    level = np.log(outage.exponent_scale(CHANNEL) * 75.0**3)
    fit = ReceptionFit(POOLED, np.zeros((1, packet_counting.STATISTICS)), np.array([level]), np.array([3.0]))
    weights = np.array([0.3, PATCH, 1.0, 2.037])
    rows, estimates = np.zeros(4, dtype=np.int64), np.full(4, 90.0)
    for _ in range(3000):
        estimates = estimates + 0.02 * packet_counting.drift(fit, rows, estimates, TEAM, 75.0, weights)
    grid = np.linspace(50.0, 100.0, 500_001)
    best = [grid[np.argmax(log_index(grid, weight, CHANNEL))] for weight in weights]
    np.testing.assert_allclose(estimates, best, atol=2e-4)
    assert best[1] == pytest.approx(BEST, abs=2e-4)


def test_a_measured_estimate_of_weight_one_has_the_digits_of_none() -> None:
    fit = packet_counting.no_counts(POOLED, 1)
    rows, estimates = np.zeros(5, dtype=np.int64), np.linspace(30.0, 140.0, 5)
    plain = packet_counting.drift(fit, rows, estimates, TEAM, 75.0)
    np.testing.assert_array_equal(packet_counting.drift(fit, rows, estimates, TEAM, 75.0, np.ones(5)), plain)


def test_the_slope_of_s_counts_its_second_factor_by_its_weight() -> None:
    r, step = np.linspace(30.0, 140.0, 12), 1e-4
    weights = np.full(len(r), 0.4)
    slope, curvature = objective.log_preference_derivatives(r, TEAM, weights)

    def log(at: Floats) -> Floats:
        value: Floats = np.log(1.0 - np.exp(-((at / 50.0) ** 4))) - 0.4 * (at / 150.0) ** 4
        return value

    np.testing.assert_allclose(slope, (log(r + step) - log(r - step)) / (2.0 * step), rtol=1e-6, atol=1e-10)
    np.testing.assert_allclose(curvature, (log(r + 0.01) - 2.0 * log(r) + log(r - 0.01)) / 1e-4, rtol=1e-4, atol=1e-9)


def sought(ticks: int, weights: Any) -> list[Floats]:
    """The states of the law for two robots in range, with the quality weight `weights(tick)` of both, or None."""
    law = OracleSeeking(OracleConfig(), surroundings.context(2, CHANNEL))
    seen = surroundings.around(surroundings.pair(70.0))
    none = seen.links.select(np.zeros(2, dtype=np.bool_))
    entry = Entry(0, np.ones(2, dtype=np.bool_), np.full(2, np.nan))
    state, states = law.relink(law.start(), none, seen.links, entry), []
    for tick in range(ticks):
        weight = weights(tick)
        around = seen._replace(tick=tick, quality_weight=None if weight is None else np.full(2, weight))
        state = law.seek(state, around)
        states.append(state)
    return states


def test_an_oracle_s_estimates_go_to_the_optimum_of_the_weight() -> None:
    assert sought(2000, lambda tick: PATCH)[-1][ESTIMATE] == pytest.approx(BEST, abs=0.01)
    assert sought(2000, lambda tick: None)[-1][ESTIMATE] == pytest.approx(68.1138, abs=0.01)


def test_a_change_of_the_weight_does_not_push_the_estimates() -> None:
    """Without the correction of the baseline, the washout would take the change of the sample for a slope."""
    states = sought(1510, lambda tick: PATCH if tick < 1500 else 0.9 * PATCH)
    before, after = states[1499][ESTIMATE], states[1500][ESTIMATE]
    # what remains is one tick of climbing the new index, at most 0.3 m/s near the optimum
    assert np.abs(after - before).max() < 0.3 * 0.02
    changed = FormulaIndex(TEAM, CHANNEL, "log", np.full(2, 0.9 * PATCH))(before) - FormulaIndex(
        TEAM, CHANNEL, "log", np.full(2, PATCH)
    )(before)
    assert np.abs(40000.0 * changed).min() > 100.0  # such a jump of the sample, in the unit of the baseline
    assert states[1500][BASELINE] - states[1499][BASELINE] == pytest.approx(40000.0 * changed, rel=0.2)
    assert states[1500][WEIGHT].tolist() == [0.9 * PATCH] * 2


def test_a_new_link_begins_with_the_weight_of_its_robot() -> None:
    """A link that begins later gets the baseline of the weighted index, as if it had begun with it."""
    first = sought(1, lambda tick: PATCH)[0]
    index = FormulaIndex(TEAM, CHANNEL, "log", np.full(2, PATCH))
    sample = 40000.0 * index(first[ESTIMATE])
    assert first[BASELINE] == pytest.approx(sample, rel=0.05)
    assert len(sought(1, lambda tick: None)[0]) == WEIGHT  # no fourth row without weights
