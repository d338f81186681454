"""The reference figures over seeds: the corrected law on both graphs, and the log index from any start."""

import numpy as np
import pytest

from agents.laws import oracle, perturbation
from agents.laws.perturbation import Seeker
from console.backends import inprocess
from fes.arrays.types import Floats
from fes.model.config import ChannelConfig, ObjectiveConfig
from fes.model.seeking import OracleConfig
from tests.support.loop import load

SEEDS = range(20)

# Median (and, in brackets, largest) times [s] of an independent study: 20 other seeds, no loss, no radio delay.
# Each median here is at most 1.1 of the study's median. The exception is the formation's time on two nearest, whose
# graph switches: its limits are the study's own median and largest time, 27.3 (37.0).
MEDIANS = {
    "two_nearest": {"disagreement_1m": 1.48, "estimate_1m": 4.16, "estimate_0_1m": 6.64},
    "relative_neighborhood": {
        "disagreement_1m": 0.77,
        "estimate_1m": 4.20,
        "estimate_0_1m": 6.67,
        "separation_1m": 15.1,
        "separation_0_1m": 25.2,
    },
}
LARGEST = {
    "two_nearest": {"estimate_1m": 5.00, "estimate_0_1m": 7.46, "separation_0_1m": 40.0},
    "relative_neighborhood": {
        "estimate_1m": 5.00,
        "estimate_0_1m": 7.46,
        "separation_1m": 17.5,
        "separation_0_1m": 30.0,
    },
}


@pytest.mark.slow
@pytest.mark.parametrize("rule", ["two_nearest", "relative_neighborhood"])
def test_the_reference_table_holds_over_twenty_seeds(rule: str) -> None:
    summaries = [inprocess.run(load("paper.toml", formation__rule=rule, run__seed=seed), "paper") for seed in SEEDS]
    times = {
        name: np.array([summary["time_to"][name] for summary in summaries], dtype=float)
        for name in summaries[0]["time_to"]
    }
    for name, median in MEDIANS[rule].items():
        assert np.median(times[name]) <= 1.1 * median, name
    for name, largest in LARGEST[rule].items():
        assert times[name].max() <= largest, name
    if rule == "two_nearest":
        assert 16.8 <= np.median(times["separation_1m"]) <= 21.9
        assert 27.3 <= np.median(times["separation_0_1m"]) <= 37.0
        assert {len(summary["edges"]) for summary in summaries} <= {12, 13}
        assert not any(summary["links_connected_always"] for summary in summaries)
    else:
        assert {len(summary["edges"]) for summary in summaries} == {9}
        assert all(summary["links_connected_always"] for summary in summaries)
        assert max(summary["separation_error_max"] for summary in summaries) <= 0.0011
    assert all(summary["disk_connected_always"] for summary in summaries)
    assert max(summary["separation_error_max"] for summary in summaries) <= 0.1


@pytest.mark.parametrize(("nearest", "optimal"), [(50.0, 68.113761), (100.0, 105.384321)])
def test_one_gain_on_the_log_index_serves_every_start_and_objective(nearest: float, optimal: float) -> None:
    """< 0.1 m within 9.4 s from any start in [25, 145] m, for a link alone."""
    index = oracle.FormulaIndex(ObjectiveConfig(minimum_separation=nearest), ChannelConfig(), "log")
    last = _last_time_beyond(Seeker(OracleConfig(), index, 0.02), np.arange(25.0, 146.0, 5.0), optimal)
    assert last.max() <= 9.4


def test_the_plain_index_needs_another_gain_for_another_objective() -> None:
    """From 145 m with r_min 50, and from 25 m with r_min 100: times from scipy's solve_ivp on (18), rtol 1e-8."""
    starts = np.arange(25.0, 146.0, 5.0)
    slowest = []
    for nearest, optimal in ((50.0, 68.113761), (100.0, 105.384321)):
        index = oracle.FormulaIndex(ObjectiveConfig(minimum_separation=nearest), ChannelConfig(), "none")
        plain = OracleConfig(index_transform="none", index_gain=44460.0)
        slowest.append(_last_time_beyond(Seeker(plain, index, 0.02), starts, optimal).max())
    assert slowest == pytest.approx([13.46, 38.70], abs=0.02)


def _last_time_beyond(seeker: Seeker, starts: Floats, optimal: float) -> Floats:
    """For links alone from `starts` the last time [s] 0.1 m or more from the optimum, within 40 s."""
    state, last = perturbation.begin(seeker, 0, starts), np.zeros(len(starts))
    for tick in range(round(40.0 / seeker.dt)):
        last[np.abs(state[perturbation.ESTIMATE] - optimal) >= 0.1] = (tick + 1) * seeker.dt
        state = perturbation.advance(seeker, tick, state, np.full(len(starts), np.nan))
    return last
