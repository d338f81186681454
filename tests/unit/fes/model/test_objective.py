"""The robots' own half of (16) against its formula and its derivative by complex step."""

import cmath
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fes.model import objective
from fes.model.config import ObjectiveConfig
from tests.support import reference as witness

objectives = st.builds(
    ObjectiveConfig,
    minimum_separation=st.floats(20.0, 90.0),
    maximum_separation=st.floats(100.0, 300.0),
    shape_exponent=st.floats(1.0, 6.0),
)


@given(team_objective=objectives, separation=st.floats(5.0, 400.0))
def test_preference_is_the_formula_of_16(team_objective: ObjectiveConfig, separation: float) -> None:
    spread = (separation / team_objective.minimum_separation) ** team_objective.shape_exponent
    reach = (separation / team_objective.maximum_separation) ** team_objective.shape_exponent
    expected = -math.expm1(-spread) * math.exp(-reach)
    result = float(objective.preference(np.array([separation]), team_objective)[0])
    # the exponent `reach` comes out of two powers: its rounding is multiplied by its size
    assert result == pytest.approx(expected, rel=1e-13 * (1.0 + reach), abs=1e-300)


@given(team_objective=objectives, separation=st.floats(5.0, 400.0))
def test_log_preference_slope_is_the_derivative_of_log_preference(
    team_objective: ObjectiveConfig, separation: float
) -> None:
    minimum, maximum = team_objective.minimum_separation, team_objective.maximum_separation
    shape = team_objective.shape_exponent

    def log_preference(r: complex) -> complex:
        # ln S, taken apart so that neither factor underflows
        return cmath.log(1.0 - cmath.exp(-((r / minimum) ** shape))) - (r / maximum) ** shape

    result = float(objective.log_preference_slope(np.array([separation]), team_objective)[0])
    expected = witness.complex_step(log_preference, separation)
    # Two terms of size shape/r and shape/r (r/r_x)^shape cancel; the witness' own 1 - exp(-spread) loses
    # 1e-16/spread, and spread >= (5/120)^6 = 5e-9.
    size = shape / separation * (1.0 + (separation / maximum) ** shape)
    spread = (separation / minimum) ** shape
    assert abs(result - expected) <= size * (1e-13 + 1e-15 / min(spread, 1.0))


def test_close_robots_prefer_to_spread_and_far_ones_to_contract() -> None:
    near, far = objective.log_preference_slope(np.array([1.0, 1e3]), ObjectiveConfig())
    # r -> 0: S ~ (r/50)^4, so the slope is 4/r; r -> inf: S ~ exp(-(r/150)^4), so it is -4 r^3/150^4
    assert near == pytest.approx(4.0 / 1.0, rel=1e-6)  # corrections of order (1/50)^4 = 1.6e-7
    assert far == pytest.approx(-4.0 * 1e3**3 / 150.0**4, rel=1e-12)


def test_preference_takes_any_shape_and_leaves_its_argument_alone() -> None:
    r = np.full((2, 3), 60.0)
    result = objective.preference(r, ObjectiveConfig())
    expected = (1.0 - math.exp(-((60 / 50) ** 4))) * math.exp(-((60 / 150) ** 4))
    np.testing.assert_allclose(result, np.full((2, 3), expected), rtol=1e-14)  # a few roundings
    assert (r == 60.0).all()
