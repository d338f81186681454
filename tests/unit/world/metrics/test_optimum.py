"""r*, and the index around it, against the settled figures, complex steps and scipy's optimizer."""

import cmath
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agents.laws import oracle
from fes.arrays.types import Floats
from fes.model import objective, outage
from fes.model.config import ChannelConfig, ObjectiveConfig
from tests.support import reference as witness
from world.metrics import optimum

PAPER = ChannelConfig()
NEAR = ObjectiveConfig(minimum_separation=50.0)
FAR = ObjectiveConfig(minimum_separation=100.0)
CASES = [(NEAR, witness.OPTIMUM_50), (FAR, witness.OPTIMUM_100)]

objectives = st.builds(
    ObjectiveConfig,
    minimum_separation=st.floats(20.0, 90.0),
    maximum_separation=st.floats(130.0, 300.0),
    shape_exponent=st.floats(1.5, 6.0),
)
channels = st.builds(
    ChannelConfig,
    reference_snr=st.floats(1e6, 1e9),
    spectral_efficiency=st.floats(0.5, 4.0),
    path_loss_exponent=st.floats(2.0, 4.0),
)


def log_index(r: complex, team_objective: ObjectiveConfig, channel: ChannelConfig) -> complex:
    """ln J of (16), written from the paper."""
    spread = (r / team_objective.minimum_separation) ** team_objective.shape_exponent
    reach = (r / team_objective.maximum_separation) ** team_objective.shape_exponent
    loss = (math.exp2(channel.spectral_efficiency) - 1.0) / channel.reference_snr * r**channel.path_loss_exponent
    return cmath.log(1.0 - cmath.exp(-spread)) - reach - loss


def log_index_slope(r: Floats, team_objective: ObjectiveConfig, channel: ChannelConfig) -> Floats:
    """(ln J)' [1/m] of (16), of the two parts under test."""
    return objective.log_preference_slope(r, team_objective) + outage.log_reception_slope(r, channel)


@pytest.mark.parametrize(("team_objective", "expected"), CASES)
def test_the_optima_are_those_of_figure_3(team_objective: ObjectiveConfig, expected: float) -> None:
    assert optimum.optimal_separation(team_objective, PAPER) == pytest.approx(expected, abs=5e-7)  # half a digit


@pytest.mark.parametrize(
    ("team_objective", "value", "curvature", "skew"),
    [(NEAR, 0.843850, -1.12460e-3, 1.01216e-4), (FAR, 0.390990, -4.59919e-4, 1.35742e-6)],
)
def test_the_index_at_the_optimum_has_the_settled_value_slope_and_curvature(
    team_objective: ObjectiveConfig, value: float, curvature: float, skew: float
) -> None:
    best = optimum.optimal_separation(team_objective, PAPER)
    index = oracle.FormulaIndex(team_objective, PAPER, "none")
    h = 0.05  # m; stencils of fourth order leave about J'''''' h^4 = 1e-13, roundings 1e-16/h^2, 1e-16/h^3
    back, far, near, middle, ahead, beyond, forth = index(best + h * np.arange(-3.0, 4.0))
    assert middle == pytest.approx(value, abs=5e-7)  # half a digit, as below
    assert (far - 8 * near + 8 * ahead - beyond) / (12 * h) == pytest.approx(0.0, abs=1e-11)
    second = (-far + 16 * near - 30 * middle + 16 * ahead - beyond) / (12 * h * h)
    assert second == pytest.approx(curvature, abs=5e-9 if team_objective is NEAR else 5e-10)
    third = (back - 8 * far + 13 * near - 13 * ahead + 8 * beyond - forth) / (8 * h**3)
    assert third == pytest.approx(skew, abs=5e-10 if team_objective is NEAR else 5e-11)


@pytest.mark.parametrize(("team_objective", "curvature"), [(NEAR, -1.3327e-3), (FAR, -1.1763e-3)])
def test_the_log_index_at_the_optimum_has_the_settled_curvature(
    team_objective: ObjectiveConfig, curvature: float
) -> None:
    best = optimum.optimal_separation(team_objective, PAPER)
    h = 1e-3  # m; the central difference leaves (ln J)'''' h^2/6 = 1e-13
    ahead, behind = log_index_slope(np.array([best + h, best - h]), team_objective, PAPER)
    assert (ahead - behind) / (2 * h) == pytest.approx(curvature, abs=5e-8)  # half a digit


@given(team_objective=objectives, channel=channels, separation=st.floats(10.0, 300.0))
def test_log_index_slope_is_the_derivative_of_the_log_index(
    team_objective: ObjectiveConfig, channel: ChannelConfig, separation: float
) -> None:
    result = float(log_index_slope(np.array([separation]), team_objective, channel)[0])
    expected = witness.complex_step(lambda r: log_index(r, team_objective, channel), separation)
    scale = (2.0**channel.spectral_efficiency - 1.0) / channel.reference_snr
    terms = (
        (separation / team_objective.maximum_separation) ** team_objective.shape_exponent
        + scale * separation**channel.path_loss_exponent
        + 1.0
    )
    spread = (separation / team_objective.minimum_separation) ** team_objective.shape_exponent
    # three terms cancel; the witness' 1 - exp(-spread) loses 1e-16/spread
    assert abs(result - expected) <= 6.0 * terms / separation * (1e-13 + 1e-15 / min(spread, 1.0))


@settings(max_examples=200)
@given(team_objective=objectives, channel=channels)
def test_no_separation_is_better_than_the_optimum(team_objective: ObjectiveConfig, channel: ChannelConfig) -> None:
    best = optimum.optimal_separation(team_objective, channel)
    expected = witness.maximizer(
        lambda r: log_index(r, team_objective, channel).real, 1.0, team_objective.maximum_separation
    )
    # A maximum read from values is known to sqrt(2e-16 |ln J|/(r^2 (ln J)'')) = 1e-7 of r or so.
    assert best == pytest.approx(expected, rel=1e-6)
    slope = witness.complex_step(lambda r: log_index(r, team_objective, channel), best)
    assert abs(slope) * best < 1e-10  # r (ln J)' is of order 1 one meter away


def test_without_losses_the_optimum_is_that_of_the_objective_alone() -> None:
    # p = 1: A/(e^A - 1) = (r/150)^4 = A/81 with A = (r/50)^4, so e^A = 82
    expected = 50.0 * math.log(82.0) ** 0.25
    best = optimum.optimal_separation(NEAR, ChannelConfig(model="perfect"))
    assert best == pytest.approx(expected, rel=1e-12)  # bisection to rounding


@given(
    team_objective=objectives,
    channel=channels,
    separation=st.lists(st.floats(0.1, 400.0), min_size=1, max_size=6),
)
def test_the_oracles_index_is_preference_times_reception(
    team_objective: ObjectiveConfig, channel: ChannelConfig, separation: list[float]
) -> None:
    r = np.array(separation)
    result = oracle.FormulaIndex(team_objective, channel, "none")(r)
    expected = objective.preference(r, team_objective) * outage.reception_probability(r, channel)
    # one exponential of a sum against a product of two: roundings times the exponent, which 1e-300 bounds
    np.testing.assert_allclose(result, expected, rtol=1e-12, atol=1e-290)
    assert r.tolist() == separation  # the argument is unchanged


def test_the_oracles_index_is_equation_33() -> None:
    r = np.linspace(5.0, 200.0, 40)
    expected = [witness.paper_index(value) for value in r.tolist()]
    np.testing.assert_allclose(oracle.FormulaIndex(NEAR, PAPER, "none")(r), expected, rtol=1e-13)  # roundings


def test_an_estimate_thrown_below_zero_has_a_finite_and_vanishing_index() -> None:
    result = oracle.FormulaIndex(NEAR, PAPER, "none")(np.array([-30.0, 0.0]))
    assert (result >= 0.0).all()
    assert (result < 1e-40).all()  # (1e-9/50)^4 = 1.6e-43


def test_the_log_index_is_the_logarithm_of_the_index() -> None:
    r = np.linspace(5.0, 200.0, 400)
    for team_objective in (NEAR, ObjectiveConfig(minimum_separation=100.0, shape_exponent=3.0)):
        expected = np.log(oracle.FormulaIndex(team_objective, PAPER, "none")(r))
        np.testing.assert_allclose(
            oracle.FormulaIndex(team_objective, PAPER, "log")(r), expected, rtol=1e-12
        )  # roundings


def test_the_curvature_of_the_log_index_hardly_depends_on_the_objective() -> None:
    """(ln J)'' = -1.3327e-3 and -1.1763e-3 at the two optima, where J'' differs by a factor of 2.4."""
    h = 0.01  # m; central differences of ln J are then exact to 1e-8
    for team_objective, curvature in ((NEAR, -1.3327e-3), (ObjectiveConfig(minimum_separation=100.0), -1.1763e-3)):
        points = optimum.optimal_separation(team_objective, PAPER) + h * np.array([-1.0, 0.0, 1.0])
        below, middle, above = oracle.FormulaIndex(team_objective, PAPER, "log")(points)
        assert (below - 2.0 * middle + above) / h**2 == pytest.approx(curvature, rel=1e-4)
