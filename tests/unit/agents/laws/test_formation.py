"""The formation law (6), (7) with the weights (9), against hand algebra and an integrated heading."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.laws import formation
from fes.arrays.edges import Edges
from fes.arrays.types import Floats
from fes.model.config import FormationConfig
from tests.support import layouts
from tests.support import reference as witness

CONFIG = FormationConfig()  # mu = 1, mu' = 10
LINEAR, ANGULAR = 0, 1


def links(*peers: int) -> Edges:
    """The links of robot 0."""
    return layouts.edges([0], [(0, peer) for peer in peers])


def unit(angle: Floats) -> Floats:
    """[2, l]"""
    return np.stack([np.cos(angle), np.sin(angle)])


@pytest.mark.parametrize(
    ("peers", "error", "expected"),
    [
        ([5], [3.0], [1 / 2]),  # a single neighbor: 1/2
        ([1, 2], [1.0, -2.0], [1 / 2, 1 / 2]),  # two: the others' half goes to one
        ([1, 2, 3], [1.0, -4.0, 3.0], [1 / 4, 1 / 2, 1 / 4]),  # largest by magnitude
        ([1, 2, 3], [4.0, -4.0, 3.0], [1 / 2, 1 / 4, 1 / 4]),  # a tie: the lowest id
        ([4, 7, 9], [3.0, -5.0, 5.0], [1 / 4, 1 / 2, 1 / 4]),
        ([1, 2, 3, 4], [0.0, 0.0, 0.0, 0.0], [1 / 2, 1 / 6, 1 / 6, 1 / 6]),
    ],
)
def test_weights_are_those_of_9(peers: list[int], error: list[float], expected: list[float]) -> None:
    assert formation.weights(links(*peers), np.array(error)).tolist() == expected


def test_weights_of_a_crew_are_each_robots_own() -> None:
    among = layouts.edges([2, 4, 6], [(2, 4), (2, 6), (6, 1), (6, 2), (6, 4)])  # robot 4 has no link
    result = formation.weights(among, np.array([1.0, 9.0, -8.0, 2.0, 3.0]))
    assert result.tolist() == [1 / 2, 1 / 2, 1 / 2, 1 / 4, 1 / 4]


@given(error=st.lists(st.floats(-100.0, 100.0), min_size=2, max_size=9))
def test_weights_sum_to_one_with_two_neighbors_or_more(error: list[float]) -> None:
    result = formation.weights(links(*range(1, len(error) + 1)), np.array(error))
    assert math.fsum(result) == pytest.approx(1.0, abs=1e-15)  # rounding of 1/(2(n - 1))


def test_a_robot_without_links_stands_still() -> None:
    vector = formation.formation_vector(links(), np.zeros(0), np.zeros((2, 0)))
    assert formation.twist(vector, np.array([0.7]), 0.02, CONFIG).tolist() == [[0.0, 0.0]]


@given(
    error=st.lists(st.floats(-60.0, 60.0), min_size=1, max_size=6),
    angle=st.lists(st.floats(-math.pi, math.pi), min_size=6, max_size=6),
    heading=st.floats(-math.pi, math.pi),
)
def test_for_a_vanishing_tick_the_twist_is_the_sums_of_6_and_7(
    error: list[float], angle: list[float], heading: float
) -> None:
    n = len(error)
    largest = max(range(n), key=lambda k: abs(error[k]))
    weight = [1 / 2 if k == largest else 1 / (2 * (n - 1)) for k in range(n)]
    v = sum(a * e * math.cos(psi - heading) for a, e, psi in zip(weight, error, angle, strict=False))
    omega = 10.0 * sum(a * e * math.sin(psi - heading) for a, e, psi in zip(weight, error, angle, strict=False))
    vector = formation.formation_vector(links(*range(1, n + 1)), np.array(error), unit(np.array(angle[:n])))
    result = formation.twist(vector, np.array([heading]), 1e-7, CONFIG)[0]
    assert result[LINEAR] == pytest.approx(v, abs=1e-12)  # m/s; roundings of 60 m
    # omega is a mean over the tick: off by (mu'|g|)^2 dt/4 <= 0.01 for |g| <= 60 m; a difference of two
    # angles over the tick: 1e-15/dt
    assert result[ANGULAR] == pytest.approx(omega, abs=0.02)


@pytest.mark.parametrize("dt", [0.02, 0.05])
@pytest.mark.parametrize("size", [1e-6, 0.01, 1.0, 40.0])
@pytest.mark.parametrize("begin", [-3.1, -1.0, -1e-3, 0.0, 0.5, math.pi / 2, 3.14])
def test_the_heading_turns_along_the_flow_of_7_for_a_constant_formation_vector(
    begin: float, size: float, dt: float
) -> None:
    after = witness.flow(lambda t, x: (-10.0 * size * math.sin(x[0]),), [begin], 0.0, dt)[0]
    heading = 2.5  # any
    vector = size * unit(np.array([heading + begin])).T
    v, omega = formation.twist(vector, np.array([heading]), dt, CONFIG)[0]
    # delta is the bearing of the pull from the heading: the heading turns by begin - after. 1e-8 rad is
    # the integrator's error (1e-11 relative) where it leaves the saddle at pi: grown e^8 = 3000-fold.
    assert omega * dt == pytest.approx(begin - after, abs=1e-8)
    assert v == pytest.approx(size * math.cos(begin), abs=1e-13)  # roundings of 40 m/s


def test_a_large_formation_vector_turns_the_heading_onto_it_and_not_beyond() -> None:
    # Euler would turn by 10 * 40 * sin(1) * 0.02 = 6.7 rad; the exact flow by 1 rad
    _, omega = formation.twist(np.array([[40.0, 0.0]]), np.array([-1.0]), 0.02, CONFIG)[0]
    assert omega * 0.02 == pytest.approx(1.0, abs=2e-3)  # rad; e^{-8} of it is left
    assert omega * 0.02 < 1.0


@given(
    turn=st.floats(-math.pi, math.pi),
    shift=st.tuples(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3)),
    seed=st.integers(0, 50),
)
def test_turning_and_shifting_the_whole_team_changes_no_twist(
    turn: float, shift: tuple[float, float], seed: int
) -> None:
    where = layouts.scatter(np.random.default_rng(seed), 6, 100.0)
    c, s = math.cos(turn), math.sin(turn)
    moved = where.copy()
    moved[:, 0] = c * where[:, 0] - s * where[:, 1] + shift[0]
    moved[:, 1] = s * where[:, 0] + c * where[:, 1] + shift[1]
    moved[:, 2] = where[:, 2] + turn
    twists = [_twists(poses) for poses in (where, moved)]
    # 1e3 m in double: 1e-13 m; bearings of robots >= 1 m apart, and omega = 50/s times the heading's error
    np.testing.assert_allclose(twists[0], twists[1], atol=1e-9)


def _twists(where: Floats) -> Floats:
    known = layouts.hear(where, range(len(where)), reach=1e6)
    bearing = np.stack([known.dx, known.dy]) / known.separation
    vector = formation.formation_vector(known.edges, known.separation - 68.0, bearing)
    return formation.twist(vector, where[:, 2], 0.02, CONFIG)


def test_limits_cut_speeds_and_keep_their_signs() -> None:
    limited = FormationConfig(linear_limit=2.0, angular_limit=0.5)
    vector = np.array([[9.0, 9.0], [-9.0, 9.0], [-9.0, -9.0], [1e-3, 1e-3]])
    result = formation.twist(vector, np.zeros(4), 0.02, limited)
    free = formation.twist(vector, np.zeros(4), 0.02, CONFIG)
    assert result[:3].tolist() == [[2.0, 0.5], [-2.0, 0.5], [-2.0, -0.5]]
    assert result[3].tolist() == free[3].tolist()
    assert abs(free[:3]).min() > 2.0  # so that the limit applies


@pytest.mark.parametrize("gain", [0.5, 3.0])
def test_speed_is_proportional_to_its_gain(gain: float) -> None:
    vector, heading = np.array([[1.0, 2.0]]), np.array([0.3])
    result = formation.twist(vector, heading, 0.02, FormationConfig(linear_gain=gain))
    assert result[0, LINEAR] == pytest.approx(gain * (math.cos(0.3) + 2.0 * math.sin(0.3)), rel=1e-14)  # rounding
