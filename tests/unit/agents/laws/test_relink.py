"""How estimates begin: carried over, from the robot's own mean, or from a seeded draw."""

import numpy as np
import pytest

from agents.laws import perturbation
from agents.laws.perturbation import BASELINE, DRIFT, ESTIMATE, Seeker
from fes.arrays.edges import Edges
from fes.model.config import SeekingConfig
from tests.support.layouts import edges

SEED = 11


def constant(
    separation: np.ndarray[tuple[int, ...], np.dtype[np.float64]],
) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """An index that is 0.5 everywhere."""
    return np.full_like(separation, 0.5)


SEEKER = Seeker(SeekingConfig(index_gain=10.0, initial_estimate=(50.0, 90.0)), constant, 0.02)
NOBODY_FRESH = np.zeros(2, dtype=np.bool_)


def untold(links: Edges) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Neighbors that say nothing."""
    return np.full(len(links.ids), np.nan)


def state_of(*estimates: float) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """[3, l] with drifts and baselines that nothing else has."""
    found = np.arange(3.0 * len(estimates)).reshape(3, -1) - 100.0
    found[ESTIMATE] = estimates
    return found


def test_a_link_that_stands_keeps_its_state() -> None:
    old = edges([0, 1], [(0, 2), (0, 3), (1, 2)])
    state = state_of(60.0, 70.0, 80.0)
    new = edges([0, 1], [(0, 3), (1, 2)])
    found = perturbation.relink(SEEKER, SEED, 5, old, state, new, NOBODY_FRESH, untold(new))
    assert found.tolist() == state[:, 1:].tolist()


def test_a_new_link_begins_at_its_robots_own_mean() -> None:
    old = edges([0, 1], [(0, 2), (0, 3), (1, 2)])
    new = edges([0, 1], [(0, 2), (0, 4), (1, 2), (1, 5)])
    found = perturbation.relink(SEEKER, SEED, 5, old, state_of(60.0, 70.0, 80.0), new, NOBODY_FRESH, untold(new))
    assert found[ESTIMATE].tolist() == [60.0, 65.0, 80.0, 80.0]  # (60 + 70)/2, though link 0-3 is gone
    assert found[DRIFT, 1] == found[DRIFT, 3] == 0.0
    assert found[BASELINE, 1] == found[BASELINE, 3] == 5.0  # the first sample: gain 10 times 0.5


def test_the_first_links_of_a_robot_are_drawn_from_the_interval() -> None:
    n = 400
    old, new = edges(range(n), []), edges(range(n), [(i, (i + 1) % n) for i in range(n)])
    found = perturbation.relink(SEEKER, SEED, 2, old, np.zeros((3, 0)), new, np.zeros(n, dtype=np.bool_), untold(new))
    drawn = found[ESTIMATE]
    assert drawn.min() >= 50.0
    assert drawn.max() < 90.0
    assert len(set(drawn.tolist())) == n
    # uniform on 40 m: standard error of the mean 40/sqrt(12 n) = 0.58 m; 4 sigma
    assert drawn.mean() == pytest.approx(70.0, abs=4 * 0.58)


def test_a_fresh_robots_further_links_are_drawn_too() -> None:
    old, new = edges([0, 1], [(0, 2), (1, 2)]), edges([0, 1], [(0, 2), (0, 3), (1, 2), (1, 3)])
    state = state_of(60.0, 80.0)
    found = perturbation.relink(SEEKER, SEED, 2, old, state, new, np.array([True, False]), untold(new))[ESTIMATE]
    from_nothing = perturbation.relink(
        SEEKER, SEED, 2, edges([0, 1], []), np.zeros((3, 0)), new, NOBODY_FRESH, untold(new)
    )[ESTIMATE]
    assert found.tolist() == [60.0, from_nothing[1], 80.0, 80.0]
    assert found[1] not in (60.0, 80.0)


def test_a_first_estimate_depends_on_seed_robot_and_peer_only() -> None:
    crew = perturbation.first_estimates(SEEKER, SEED, edges([0, 3, 4], [(0, 3), (3, 0), (3, 4), (4, 3)]))
    single = perturbation.first_estimates(SEEKER, SEED, edges([3], [(3, 0), (3, 4), (3, 9)]))
    assert crew[1:3].tolist() == single[:2].tolist()
    assert crew[0] != crew[1]  # the two ends of a link draw each their own
    other = perturbation.first_estimates(SEEKER, SEED + 1, edges([3], [(3, 0)]))
    assert other[0] != single[0]


def test_an_interval_of_one_point_is_that_point() -> None:
    exact = Seeker(SeekingConfig(initial_estimate=(77.0, 77.0)), constant, 0.02)
    assert perturbation.first_estimates(exact, SEED, edges([0], [(0, 1), (0, 2)])).tolist() == [77.0, 77.0]


def test_a_robot_that_comes_late_begins_with_what_its_neighbors_tell_it() -> None:
    old, new = edges([0, 1], []), edges([0, 1], [(0, 2), (0, 3), (1, 2)])
    told = np.array([71.5, np.nan])
    found = perturbation.relink(SEEKER, SEED, 900, old, np.zeros((3, 0)), new, np.ones(2, dtype=np.bool_), told)[
        ESTIMATE
    ]
    drawn = perturbation.first_estimates(SEEKER, SEED, new)
    assert found.tolist() == [71.5, 71.5, drawn[2]]
