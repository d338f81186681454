"""The seeking law (18) against a scalar transcription of it, integrated with variable step."""

import math
from dataclasses import replace

import numpy as np
import pytest

from agents.laws import perturbation
from agents.laws.perturbation import BASELINE, DRIFT, ESTIMATE, Seeker
from fes.arrays.types import Floats
from tests.support import reference as witness
from tests.support.scalar_law import AMPLITUDE, DT, FREQUENCY, KAPPA, LOW_PASS, equation_18, seeker

"""a, beta_0, kappa, beta_l, beta_h of the paper."""
NO_INDEX = 1e-12
"""An index gain that leaves nothing but the consensus."""
UNHEARD = math.nan


def coast(seeking: Seeker, state: Floats, ticks: int, peer: Floats) -> list[Floats]:
    """The states of some ticks; `peer` [l] is the position of the link that each link hears, or -1 for none."""
    states = [state]
    for tick in range(ticks):
        heard = np.where(peer >= 0, states[-1][ESTIMATE][peer.astype(int)], np.nan)
        states.append(perturbation.advance(seeking, tick, states[-1], heard))
    return states


TWO = np.array([1.0, 0.0])
ALONE = np.array([-1.0])


@pytest.mark.parametrize("law", ["consensus", "paper"])
@pytest.mark.parametrize("heard", [80.0, 61.0, UNHEARD])
def test_the_law_is_equation_18(law: str, heard: float) -> None:
    seeking = seeker(law, sub_step=2e-4)
    state = perturbation.begin(seeking, 3, np.array([60.0, 85.0]))
    state[DRIFT] = [0.5, -2.0]
    expected = state.copy()
    for tick in range(3, 18):
        state = perturbation.advance(seeking, tick, state, np.full(2, heard))
        for link in range(2):
            rate = equation_18(law, 44460.0, heard)
            expected[:, link] = witness.flow(rate, expected[:, link].tolist(), tick * DT, (tick + 1) * DT)
    assert abs(expected[ESTIMATE] - [60.0, 85.0]).min() > 0.1  # something happened
    # RK4 with a step of 2e-4 s at 100 rad/s: (0.02)^4/120 = 1e-9 of the index's 4e4 in the baseline
    np.testing.assert_allclose(state[:2], expected[:2], atol=1e-5)
    np.testing.assert_allclose(state[BASELINE], expected[BASELINE], rtol=1e-9)


def integration_error(start: list[float], peer: Floats, sub_step: float = 0.01) -> float:
    """Largest error of the estimates in 6 s, as a fraction of the longest travel."""
    seeking = seeker(sub_step=sub_step)
    states = coast(seeking, perturbation.begin(seeking, 0, np.array(start)), 300, peer)
    exact = states[0].copy()
    error = 0.0
    for tick in range(300):
        heard = [exact[ESTIMATE, int(number)] if number >= 0 else UNHEARD for number in peer.tolist()]
        for link, value in enumerate(heard):
            rate = equation_18("consensus", 44460.0, value)
            exact[:, link] = witness.flow(rate, exact[:, link].tolist(), tick * DT, (tick + 1) * DT, 1e-10)
        error = max(error, float(abs(states[tick + 1][ESTIMATE] - exact[ESTIMATE]).max()))
    return error / float(abs(exact[ESTIMATE] - start).max())


def test_the_default_sub_step_errs_by_a_four_thousandth_of_the_travel() -> None:
    assert seeker().sub_steps == 2
    # science.md, section 3: 2.5e-4, for a link whose two ends start at the ends of the interval
    assert integration_error([50.0, 90.0], TWO) <= 2.5e-4


def test_an_estimate_without_exchange_errs_by_less_than_a_thousandth_of_its_travel() -> None:
    # Far from r* the slope of J varies most: 8.3e-4 from 50 m (measured), 3.0e-4 near r*.
    coarse = integration_error([50.0], ALONE)
    assert coarse <= 1e-3
    # at least fourth order: half the step, at most a sixteenth of the error
    assert coarse / integration_error([50.0], ALONE, 0.005) > 16.0


def test_the_settled_estimate_is_off_the_optimum_by_the_bias_of_the_dither() -> None:
    seeking = seeker(sub_step=2e-3)
    begin = perturbation.begin(seeking, 0, np.array([witness.OPTIMUM_50 + 0.01]))
    states = coast(seeking, begin, 1064, ALONE)
    # A tick is 2 rad of dither, so 22 ticks are 7 periods (to 0.02 rad): ripple averages out. After 15
    # time constants of 1 s, 0.01 m is 3e-9 m.
    settled = float(np.mean([state[ESTIMATE, 0] for state in states[-308:]]))
    bias = -1.01216e-4 * AMPLITUDE**2 / (8.0 * -1.12460e-3)  # -J''' a^2/(8 J'')
    assert bias == pytest.approx(4.5e-4, abs=5e-7)
    # averaging leaves terms of relative order a^2 (4 %), and r* is known to 5e-7 m
    assert settled - witness.OPTIMUM_50 == pytest.approx(bias, rel=0.04)


def test_the_printed_law_conserves_the_low_passed_estimate_plus_drift_of_each_link() -> None:
    seeking = seeker("paper", NO_INDEX)
    begin = perturbation.begin(seeking, 0, np.array([80.0, 60.0, 55.0]))
    states = coast(seeking, begin, 500, np.array([1.0, 0.0, -1.0]))
    kept = [LOW_PASS * state[ESTIMATE] + state[DRIFT] for state in states]
    np.testing.assert_allclose(kept, np.tile(LOW_PASS * begin[ESTIMATE], (501, 1)), rtol=1e-12)  # rounding
    assert abs(states[-1][ESTIMATE, 0] - 80.0) > 5.0  # while the estimates themselves moved


def test_under_the_printed_law_a_disagreement_freezes_at_a_third() -> None:
    seeking = seeker("paper", NO_INDEX)
    states = coast(seeking, perturbation.begin(seeking, 0, np.array([80.0, 60.0])), 500, TWO)
    difference = [float(state[ESTIMATE, 0] - state[ESTIMATE, 1]) for state in states]
    # 2/(2 + beta_l) of 20 m; e^{-12 t} of the rest is left: nothing after 5 s, and it stays so
    assert difference[250:] == pytest.approx([20.0 * 2.0 / (2.0 + LOW_PASS)] * 251, abs=1e-9)
    assert difference[-1] == pytest.approx(6.667, abs=5e-4)


@pytest.mark.parametrize(
    ("law", "eigenvalues"),
    [("paper", [0.0, -12.0]), ("consensus", [-6.0 + 5.2915j, -6.0 - 5.2915j])],
)
def test_a_disagreement_follows_the_matrix_exponential_of_its_law(law: str, eigenvalues: list[complex]) -> None:
    # d' = e - 2 kappa d, e' = beta_l (-e -+ 2 kappa d): the difference of two links' (18)
    sign = -1.0 if law == "paper" else 1.0
    matrix = np.array([[-2 * KAPPA, 1.0], [-sign * LOW_PASS * 2 * KAPPA, -LOW_PASS]])
    ordered = sorted(np.linalg.eigvals(matrix).tolist(), key=lambda value: (-value.real, -value.imag))
    np.testing.assert_allclose(ordered, eigenvalues, atol=5e-5)  # half of the last digit
    dt = 1e-3
    seeking = seeker(law, NO_INDEX, dt=dt)
    states = coast(seeking, perturbation.begin(seeking, 0, np.array([80.0, 60.0])), 600, TWO)
    result = np.array([state[:2, 0] - state[:2, 1] for state in states[::100]])
    expected = [witness.exponential(matrix * 0.1 * k) @ [20.0, 0.0] for k in range(7)]
    # a value held over a tick is half a tick late: kappa dt/2 = 0.2 % of 20 m, and of e <= 4 * 2 * 20 m/s
    np.testing.assert_allclose(result[:, 0], [value[0] for value in expected], atol=0.04)
    np.testing.assert_allclose(result[:, 1], [value[1] for value in expected], atol=0.32)


def test_under_the_consensus_law_a_disagreement_vanishes() -> None:
    seeking = seeker("consensus", NO_INDEX)
    states = coast(seeking, perturbation.begin(seeking, 0, np.array([80.0, 60.0])), 250, TWO)
    final = states[-1][ESTIMATE]
    # e^{-6 * 5 s} of 20 m = 2e-12 m; hearing one tick late makes it no slower than e^{-5 t}: 3e-10 m
    assert abs(final[0] - final[1]) < 1e-9
    assert final[0] == pytest.approx(70.0, abs=1e-9)  # symmetric exchange keeps the mean


def test_a_link_begins_with_its_first_sample_as_baseline_and_without_drift() -> None:
    state = perturbation.begin(seeker(), 7, np.array([55.0, 88.0]))
    probe = AMPLITUDE * math.sin(FREQUENCY * 7 * DT)
    assert abs(probe) > 0.1
    assert state[ESTIMATE].tolist() == [55.0, 88.0]
    assert state[DRIFT].tolist() == [0.0, 0.0]
    expected = [44460.0 * witness.paper_index(r + probe) for r in (55.0, 88.0)]
    np.testing.assert_allclose(state[BASELINE], expected, rtol=1e-13)  # roundings


def test_advancing_does_not_change_the_previous_state() -> None:
    seeking = seeker()
    state = perturbation.begin(seeking, 0, np.array([70.0]))
    kept = state.copy()
    after = perturbation.advance(seeking, 0, state, np.array([60.0]))
    assert np.array_equal(state, kept)
    assert not np.array_equal(after, kept)


@pytest.mark.parametrize(("dt", "steps"), [(0.02, 2), (0.05, 5), (0.01, 1), (0.003, 1), (0.021, 3), (0.03, 3)])
def test_a_tick_is_cut_into_equal_steps_no_longer_than_the_sub_step(dt: float, steps: int) -> None:
    assert replace(seeker(), dt=dt).sub_steps == steps
