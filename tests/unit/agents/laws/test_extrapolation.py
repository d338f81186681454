"""Extrapolation of a peer's estimate that was heard a while ago."""

import math

import numpy as np
import pytest

from agents.laws import perturbation
from agents.laws.perturbation import DRIFT, ESTIMATE
from fes.arrays.types import Floats
from tests.support import reference as witness
from tests.support.scalar_law import DT, equation_18, seeker


def fallen(ticks: int, late: bool, corrected: bool) -> float:
    """Fall [m] of two estimates in agreement from 75 m, each hearing the other (one tick late)."""
    seeking = seeker()
    state = perturbation.begin(seeking, 0, np.array([75.0, 75.0]))
    before = state
    for tick in range(ticks):
        heard: Floats = (before if late else state)[ESTIMATE, ::-1]
        if corrected:
            heard = perturbation.extrapolate(seeking, state, heard, np.full(2, DT if late else 0.0))
        before, state = state, perturbation.advance(seeking, tick, state, heard)
    return float(75.0 - state[ESTIMATE, 0])


def test_a_peers_estimate_is_extrapolated_by_ones_own_drift_for_up_to_a_tenth_of_a_second() -> None:
    state = np.array([[60.0] * 4, [2.0, -3.0, 2.0, 5.0], [0.0] * 4])
    heard = np.array([61.0, 61.0, 61.0, math.nan])
    result = perturbation.extrapolate(seeker(), state, heard, np.array([0.02, 0.02, 7.0, 0.02]))
    # xi times age: 2 * 0.02, -3 * 0.02, 2 * 0.1; what was never heard stays unknown
    assert result == pytest.approx([61.04, 60.94, 61.2, math.nan], rel=1e-15, nan_ok=True)


def test_the_printed_law_uses_a_peers_last_estimate_unchanged() -> None:
    heard = np.array([61.0, math.nan])
    result = perturbation.extrapolate(seeker("paper"), np.full((3, 2), 5.0), heard, np.full(2, 0.02))
    assert result == pytest.approx(heard, abs=0.0, nan_ok=True)


def test_with_extrapolation_two_agreeing_robots_climb_as_fast_as_one_despite_delay() -> None:
    ticks = 100
    start = perturbation.begin(seeker(), 0, np.array([75.0]))[:, 0].tolist()
    alone = 75.0 - witness.flow(equation_18("consensus", 44460.0, math.nan), start, 0.0, ticks * DT)[ESTIMATE]
    late, corrected = fallen(ticks, True, False), fallen(ticks, True, True)
    # A value one tick late and then held for a tick is 1.5 ticks old on average: kappa xi 0.03 s = 12 % of
    # the drift is lost; extrapolating over the one tick leaves the half tick of holding.
    assert late < 0.92 * alone
    assert corrected == pytest.approx(alone, rel=0.05)
    assert corrected == pytest.approx(fallen(ticks, False, False), rel=0.005)  # as if there were no delay


def test_an_estimate_received_in_this_tick_is_used_unchanged() -> None:
    state = np.zeros((3, 1))
    state[ESTIMATE], state[DRIFT] = 70.0, 1.0
    unchanged = perturbation.extrapolate(seeker(), state, np.array([65.0]), np.array([0.0]))
    assert unchanged.tolist() == [65.0]  # at no age nothing is added
