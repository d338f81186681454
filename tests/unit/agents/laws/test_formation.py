"""The formation law with the weights (9), and the twists (6), (7) that follow from it, against hand algebra."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.control import motion
from agents.laws import formation
from fes.arrays.edges import Edges
from fes.arrays.types import Floats
from fes.model.config import FormationConfig
from tests.support import layouts

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
    assert motion.twist(vector, np.array([0.7]), 0.02, CONFIG).tolist() == [[0.0, 0.0]]


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
    result = motion.twist(vector, np.array([heading]), 1e-7, CONFIG)[0]
    assert result[LINEAR] == pytest.approx(v, abs=1e-12)  # m/s; roundings of 60 m
    # omega is a mean over the tick: off by (mu'|g|)^2 dt/4 <= 0.01 for |g| <= 60 m; a difference of two
    # angles over the tick: 1e-15/dt
    assert result[ANGULAR] == pytest.approx(omega, abs=0.02)


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
    return motion.twist(vector, where[:, 2], 0.02, CONFIG)
