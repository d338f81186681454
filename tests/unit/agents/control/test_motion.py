"""Motion: the twists that follow a pull, against hand algebra and an integrated heading."""

import math

import numpy as np
import pytest

from agents.control import motion
from fes.arrays.types import Floats
from fes.errors import FesError
from fes.extension.protocols import Formed
from fes.model.config import FormationConfig
from fes.model.sensing import MAX_TWIST, Sensed
from tests.support import reference as witness

CONFIG = FormationConfig()  # mu = 1, mu' = 10
LIMITED = FormationConfig(linear_limit=2.0, angular_limit=0.5)
LINEAR, ANGULAR = 0, 1
NAN = math.nan
IDS = np.array([3, 7])
PULL = np.array([[1.0, 0.0], [4.0, 0.0]])
"""Of two robots that look along it: 1 m/s and 4 m/s straight ahead at mu = 1."""


def unit(angle: float) -> Floats:
    """[2]"""
    return np.array([math.cos(angle), math.sin(angle)])


def twists(config: FormationConfig, replaced: Floats | None, pull: Floats = PULL) -> Floats:
    """The twists of the two robots, of which a formation law has `replaced` some."""
    sensed = Sensed(11, np.zeros((2, 3)))
    return motion.twists(IDS, Formed(None, pull, twists=replaced), sensed, 0.02, config)


@pytest.mark.parametrize("dt", [0.02, 0.05])
@pytest.mark.parametrize("size", [1e-6, 0.01, 1.0, 40.0])
@pytest.mark.parametrize("begin", [-3.1, -1.0, -1e-3, 0.0, 0.5, math.pi / 2, 3.14])
def test_the_heading_turns_along_the_flow_of_7_for_a_constant_formation_vector(
    begin: float, size: float, dt: float
) -> None:
    after = witness.flow(lambda t, x: (-10.0 * size * math.sin(x[0]),), [begin], 0.0, dt)[0]
    heading = 2.5  # any
    vector = size * unit(heading + begin)[None]
    v, omega = motion.twist(vector, np.array([heading]), dt, CONFIG)[0]
    # delta is the bearing of the pull from the heading: the heading turns by begin - after. 1e-8 rad is
    # the integrator's error (1e-11 relative) where it leaves the saddle at pi: grown e^8 = 3000-fold.
    assert omega * dt == pytest.approx(begin - after, abs=1e-8)
    assert v == pytest.approx(size * math.cos(begin), abs=1e-13)  # roundings of 40 m/s


def test_a_large_formation_vector_turns_the_heading_onto_it_and_not_beyond() -> None:
    # Euler would turn by 10 * 40 * sin(1) * 0.02 = 6.7 rad; the exact flow by 1 rad
    _, omega = motion.twist(np.array([[40.0, 0.0]]), np.array([-1.0]), 0.02, CONFIG)[0]
    assert omega * 0.02 == pytest.approx(1.0, abs=2e-3)  # rad; e^{-8} of it is left
    assert omega * 0.02 < 1.0


def test_limits_cut_speeds_and_keep_their_signs() -> None:
    vector = np.array([[9.0, 9.0], [-9.0, 9.0], [-9.0, -9.0], [1e-3, 1e-3]])
    result = motion.twist(vector, np.zeros(4), 0.02, LIMITED)
    free = motion.twist(vector, np.zeros(4), 0.02, CONFIG)
    assert result[:3].tolist() == [[2.0, 0.5], [-2.0, 0.5], [-2.0, -0.5]]
    assert result[3].tolist() == free[3].tolist()
    assert abs(free[:3]).min() > 2.0  # so that the limit applies


@pytest.mark.parametrize("gain", [0.5, 3.0])
def test_speed_is_proportional_to_its_gain(gain: float) -> None:
    vector, heading = np.array([[1.0, 2.0]]), np.array([0.3])
    result = motion.twist(vector, heading, 0.02, FormationConfig(linear_gain=gain))
    assert result[0, LINEAR] == pytest.approx(gain * (math.cos(0.3) + 2.0 * math.sin(0.3)), rel=1e-14)  # rounding


def test_a_robot_without_a_pull_stands_still() -> None:
    assert motion.twist(np.zeros((1, 2)), np.array([0.7]), 0.02, CONFIG).tolist() == [[0.0, 0.0]]


def test_a_pull_from_behind_drives_the_robot_backwards_before_it_has_turned() -> None:
    v, omega = motion.twist(np.array([[-3.0, 0.0]]), np.array([0.0]), 0.02, CONFIG)[0]
    assert v == -3.0
    assert abs(omega) * 0.02 <= math.pi


def test_twists_of_a_law_replace_those_of_the_pull_where_they_are_numbers() -> None:
    assert twists(CONFIG, None).tolist() == [[1.0, 0.0], [4.0, 0.0]]
    replaced = np.array([[NAN, 0.25], [-9.0, NAN]])
    assert twists(CONFIG, replaced).tolist() == [[1.0, 0.25], [-9.0, 0.0]]


def test_twists_of_a_law_obey_the_limits_too() -> None:
    replaced = np.array([[-9.0, 0.75], [NAN, -0.75]])
    assert twists(LIMITED, replaced).tolist() == [[-2.0, 0.5], [2.0, -0.5]]


def test_a_twist_without_a_limit_is_bounded_by_that_of_a_command() -> None:
    pull = np.array([[1e11, 0.0], [-1e11, 0.0]])
    assert twists(CONFIG, None, pull)[:, LINEAR].tolist() == [MAX_TWIST, -MAX_TWIST]


@pytest.mark.parametrize(("bad", "robot"), [([[0.0, NAN], [0.0, 0.0]], 3), ([[0.0, 0.0], [math.inf, 0.0]], 7)])
def test_a_pull_that_is_not_finite_stops_the_crew_and_names_the_robot(bad: list[list[float]], robot: int) -> None:
    message = f"robot {robot} computed a twist that is not finite at tick 11: check gains and exponents"
    with np.errstate(invalid="ignore"), pytest.raises(FesError) as refused:
        twists(CONFIG, None, np.array(bad))
    assert str(refused.value) == message


def test_limits_do_not_change_the_twists_they_are_given() -> None:
    given = np.array([[9.0, 9.0]])
    assert motion.limited(given, LIMITED).tolist() == [[2.0, 0.5]]
    assert given.tolist() == [[9.0, 9.0]]
    assert motion.limited(given, CONFIG) is given
