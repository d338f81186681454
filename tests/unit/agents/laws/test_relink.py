"""The first estimates of links: carried over, the robot's own mean, a reported mean, or a seeded draw."""

from dataclasses import replace

import numpy as np
import pytest

from agents.laws import link_estimates, perturbation
from agents.laws.perturbation import BASELINE, DRIFT, ESTIMATE, Seeker
from agents.laws.seeking_measured import LinkSeeking, PooledSeeking
from agents.rivals.krstic_wang import KrsticWang, KrsticWangParameters
from fes.arrays.edges import Edges
from fes.arrays.types import Floats, Ints
from fes.extension.context import SeededDraws
from fes.extension.neighborhood import Entry
from fes.model.seeking import MeasuredConfig, OracleConfig
from tests.support import laws
from tests.support.layouts import edges

DRAWS = SeededDraws(11)


class RecordedDraws:
    """The draws of a seed, and the pairs of each call."""

    def __init__(self) -> None:
        self.calls: list[tuple[str, list[tuple[int, int]]]] = []

    def __call__(self, stream: str, robots: Ints, peers: Ints) -> Floats:
        self.calls.append((stream, list(zip(robots.tolist(), peers.tolist(), strict=True))))
        return DRAWS(stream, robots, peers)

    def own_ids(self, ids: Ints) -> Ints:
        return ids


class Constant:
    """An index that is 0.5 everywhere."""

    def __call__(self, separation: Floats) -> Floats:
        return np.full_like(separation, 0.5)

    def parabola(self, separation: Floats) -> tuple[Floats, Floats, Floats]:
        return self(separation), np.zeros_like(separation), np.zeros_like(separation)

    def trusted(self, separation: Floats) -> Floats:
        return np.full_like(separation, np.inf)


CONFIG = OracleConfig(index_gain=10.0, initial_estimate=(50.0, 90.0))
MEASURED = MeasuredConfig(index="measured")
SEEKER = Seeker(CONFIG, Constant(), 0.02)
NO_STATE = np.zeros((3, 0))


def entry(tick: int, *is_fresh: bool, reported: Floats | None = None) -> Entry:
    """Robots of which those marked are fresh, and whose neighbors reported nothing unless `reported` is given."""
    fresh = np.array(is_fresh)
    return Entry(tick, fresh, np.full(len(fresh), np.nan) if reported is None else reported)


def relinked(old: Edges, state: Floats, new: Edges, conditions: Entry) -> Floats:
    return perturbation.relink(SEEKER, DRAWS, old, state, new, conditions)


def state_of(*estimates: float) -> Floats:
    """[3, l] with drifts and baselines that no other link has."""
    state = np.arange(3.0 * len(estimates)).reshape(3, -1) - 100.0
    state[ESTIMATE] = estimates
    return state


def test_a_lasting_link_keeps_its_state() -> None:
    old = edges([0, 1], [(0, 2), (0, 3), (1, 2)])
    state = state_of(60.0, 70.0, 80.0)
    new = edges([0, 1], [(0, 3), (1, 2)])
    assert relinked(old, state, new, entry(5, False, False)).tolist() == state[:, 1:].tolist()


def test_a_new_link_begins_at_the_mean_estimate_of_its_robot() -> None:
    old = edges([0, 1], [(0, 2), (0, 3), (1, 2)])
    new = edges([0, 1], [(0, 2), (0, 4), (1, 2), (1, 5)])
    state = relinked(old, state_of(60.0, 70.0, 80.0), new, entry(5, False, False))
    assert state[ESTIMATE].tolist() == [60.0, 65.0, 80.0, 80.0]  # (60 + 70)/2, though link 0-3 is gone
    assert state[DRIFT, 1] == state[DRIFT, 3] == 0.0
    assert state[BASELINE, 1] == state[BASELINE, 3] == 5.0  # the first sample: gain 10 times 0.5


def test_the_first_links_of_a_robot_are_drawn_from_the_interval() -> None:
    n = 400
    old, new = edges(range(n), []), edges(range(n), [(i, (i + 1) % n) for i in range(n)])
    estimates = relinked(old, NO_STATE, new, entry(2, *[False] * n))[ESTIMATE]
    assert estimates.min() >= 50.0
    assert estimates.max() < 90.0
    assert len(set(estimates.tolist())) == n
    # uniform on 40 m: standard error of the mean 40/sqrt(12 n) = 0.58 m; 4 sigma
    assert estimates.mean() == pytest.approx(70.0, abs=4 * 0.58)


def test_further_links_of_a_new_robot_are_drawn_too() -> None:
    old, new = edges([0, 1], [(0, 2), (1, 2)]), edges([0, 1], [(0, 2), (0, 3), (1, 2), (1, 3)])
    estimates = relinked(old, state_of(60.0, 80.0), new, entry(2, True, False))[ESTIMATE]
    from_nothing = relinked(edges([0, 1], []), NO_STATE, new, entry(2, False, False))[ESTIMATE]
    assert estimates.tolist() == [60.0, from_nothing[1], 80.0, 80.0]
    assert estimates[1] not in (60.0, 80.0)


def test_a_first_estimate_depends_on_seed_robot_and_peer_only() -> None:
    crew = link_estimates.first_estimates(CONFIG, DRAWS, edges([0, 3, 4], [(0, 3), (3, 0), (3, 4), (4, 3)]))
    single = link_estimates.first_estimates(CONFIG, DRAWS, edges([3], [(3, 0), (3, 4), (3, 9)]))
    assert crew[1:3].tolist() == single[:2].tolist()
    assert crew[0] != crew[1]  # each end of a link has its own draw
    reseeded = link_estimates.first_estimates(CONFIG, SeededDraws(12), edges([3], [(3, 0)]))
    assert reseeded[0] != single[0]


def test_an_interval_of_one_point_is_that_point() -> None:
    exact = OracleConfig(initial_estimate=(77.0, 77.0))
    assert link_estimates.first_estimates(exact, DRAWS, edges([0], [(0, 1), (0, 2)])).tolist() == [77.0, 77.0]


def test_a_robot_that_joins_late_begins_with_what_its_neighbors_report() -> None:
    old, new = edges([0, 1], []), edges([0, 1], [(0, 2), (0, 3), (1, 2)])
    reported = np.array([71.5, np.nan])
    estimates = relinked(old, NO_STATE, new, entry(900, True, True, reported=reported))[ESTIMATE]
    drawn = link_estimates.first_estimates(CONFIG, DRAWS, new)
    assert estimates.tolist() == [71.5, 71.5, drawn[2]]


# Robot 0 has a mean, 1 is fresh, 2 has no link yet but heard a mean, and 3 has neither.
OLD = edges(range(4), [(0, 1), (1, 0)])
NEW = edges(range(4), [(0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1), (3, 0)])
MIXED = entry(9, False, True, False, False, reported=np.array([np.nan, np.nan, 71.5, np.nan]))


def test_only_new_links_without_a_mean_are_drawn() -> None:
    recorded = RecordedDraws()
    estimates = perturbation.relink(SEEKER, recorded, OLD, state_of(60.0, 80.0), NEW, MIXED)[ESTIMATE]
    assert recorded.calls == [(link_estimates.FIRST_ESTIMATE, [(1, 2), (3, 0)])]
    drawn = link_estimates.first_estimates(CONFIG, DRAWS, NEW)
    assert estimates.tolist() == [60.0, 60.0, 80.0, drawn[3], 71.5, 71.5, drawn[6]]


def test_links_that_all_have_a_mean_are_not_drawn() -> None:
    recorded = RecordedDraws()
    more = edges([0, 1], [(0, 2), (0, 3), (1, 2), (1, 3)])
    perturbation.relink(
        SEEKER, recorded, more.select(more.peers == 2), state_of(1.0, 2.0), more, entry(9, False, False)
    )
    assert recorded.calls == []


@pytest.mark.parametrize("law", [PooledSeeking, LinkSeeking])
def test_a_measured_law_draws_for_the_new_links_only(law: type[PooledSeeking] | type[LinkSeeking]) -> None:
    recorded = RecordedDraws()
    seeking = law(MEASURED, replace(laws.context(np.arange(4)), draws=recorded))
    calm = entry(2, *[False] * 4)
    state = seeking.relink(seeking.start(), edges(range(4), []), OLD, calm)
    recorded.calls.clear()
    relinked = seeking.relink(state, OLD, NEW, MIXED)
    staggered = [(link_estimates.STAGGER, [(0, 2), (1, 2), (0, 2), (1, 2), (0, 3)])] if law is LinkSeeking else []
    assert recorded.calls == [(link_estimates.FIRST_ESTIMATE, [(1, 2), (3, 0)]), *staggered]
    assert relinked.estimates[[0, 2]].tolist() == state.estimates.tolist()
    drawn = link_estimates.first_estimates(MEASURED, DRAWS, NEW)
    assert relinked.estimates[[3, 6]].tolist() == drawn[[3, 6]].tolist()
    if law is LinkSeeking:
        assert relinked.ahead.tolist() == link_estimates.stagger(MEASURED, DRAWS, NEW).tolist()


def test_the_law_of_krstic_and_wang_draws_for_the_new_links_only() -> None:
    recorded = RecordedDraws()
    law = KrsticWang(KrsticWangParameters(), replace(laws.context(np.arange(4)), draws=recorded))
    state = law.relink(law.start(), edges(range(4), []), OLD, entry(2, *[False] * 4))
    recorded.calls.clear()
    law.relink(state, OLD, NEW, MIXED)
    assert [pairs for _, pairs in recorded.calls] == [[(1, 2), (2, 0), (2, 1), (3, 0)]]
