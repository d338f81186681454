"""Counted beacons and the fit to them: samples, misses, exchange, and links that learn alone."""

import numpy as np
import pytest

from agents.control import contacts
from agents.laws import link_estimates, packet_counting, seeking_perturbation
from agents.laws.packet_counting import ALONE, POOLED, STATISTICS, ReceptionFit
from agents.runtime.reception import Receiver
from fes.arrays.edges import Edges
from fes.extension.context import SeededDraws
from fes.extension.neighborhood import Neighborhood
from fes.model import beacon_slots, objective
from fes.model.config import ObjectiveConfig
from fes.model.seeking import MeasuredConfig
from fes.model.sensing import Observations
from tests.support import laws, layouts


def test_the_fit_finds_level_and_slope_of_a_channel_of_its_family() -> None:
    """Samples of p = exp(-c r^nu) at separations about rho_0, without exchange and without aging."""
    rng, c, nu, scale = np.random.default_rng(4), 3e-7, 3.0, 75.0
    known = packet_counting.no_counts(POOLED, 1)
    for _ in range(4000):
        r = rng.uniform(60.0, 90.0, 26)
        decoded = rng.random(26) < np.exp(-c * r**nu)
        known = packet_counting.learn(known, np.zeros(26, dtype=np.int64), r, decoded, scale)
    # 104,000 samples at p = 0.88 (Fisher information of the two): 2 sigma are 0.02 and 0.15
    assert known.level[0] == pytest.approx(np.log(c * scale**nu), abs=0.02)
    assert known.exponent[0] == pytest.approx(nu, abs=0.15)


def test_misses_are_learnt_from_the_gap_at_separations_in_between() -> None:
    """A peer moves away by 1 m a tick; of ticks 0 to 4 only the beacons of 0 and 4 decode."""
    near = layouts.edges([0], [(0, 1)])
    now, ids, receiver = contacts.no_contacts(near.ids, 0, 0), np.array([1]), Receiver()
    result = []
    for tick in range(1, 6):
        beacons = layouts.silent_beacons(tick - 1, ids, layouts.poses([(60.0 + tick - 1, 0.0)]))
        before, code = now, 2 if tick in (1, 5) else 1
        sensed = Observations(tick, layouts.poses([(0.0, 0.0)]), near, np.array([code], dtype=np.uint8))
        now = layouts.heard(before, receiver, sensed, layouts.poses([(0.0, 0.0)]), beacons)
        at, separation, decoded = beacon_slots.between(before, now, tick, np.ones(1, dtype=np.bool_))
        result.append((at.tolist(), separation.tolist(), decoded.tolist()))
    assert result[0] == ([], [], [])  # the number missed before the first is unknown
    assert result[1:4] == [([], [], [])] * 3
    assert result[4] == ([0] * 4, [64.0, 61.0, 62.0, 63.0], [True, False, False, False])


def test_only_the_latest_slots_of_a_long_silence_are_counted() -> None:
    """A peer moves from 60 to 160 m in a million ticks in which no beacon decodes."""
    near, ids, silent = layouts.edges([0], [(0, 1)]), np.array([1]), 10**6
    before, receiver = contacts.no_contacts(near.ids, 0, 0), Receiver()
    now = before
    for tick, place in ((1, 60.0), (silent, 160.0)):
        beacons = layouts.silent_beacons(tick - 1, ids, layouts.poses([(place, 0.0)]))
        sensed = Observations(tick, layouts.poses([(0.0, 0.0)]), near, np.array([2], dtype=np.uint8))
        before, now = now, layouts.heard(now, receiver, sensed, layouts.poses([(0.0, 0.0)]), beacons)
    _, separation, decoded = beacon_slots.between(before, now, silent, np.ones(1, dtype=np.bool_))
    assert len(separation) == 1 + beacon_slots.MOST_MISSED
    assert decoded.tolist() == [True] + [False] * beacon_slots.MOST_MISSED
    step = 100.0 / (silent - 1)  # m a tick
    assert separation[1:] == pytest.approx(160.0 - step * np.arange(beacon_slots.MOST_MISSED, 0, -1), rel=1e-12)


def test_mixing_keeps_what_all_agree_on_and_ages_it() -> None:
    everybody = Edges(np.arange(3), np.array([0, 0, 1, 1, 2, 2]), np.array([1, 2, 0, 2, 0, 1]))
    metrics = np.tile(np.arange(1.0, STATISTICS + 1.0), (3, 1))
    before = ReceptionFit(POOLED, metrics, np.zeros(3), np.ones(3))
    mixed = packet_counting.mix(before, everybody, np.ones(6, dtype=np.bool_), metrics[everybody.peers])
    after = packet_counting.fade(mixed, 0.02)
    faded = np.array([np.exp(-0.02 / 6.0)] * 3 + [np.exp(-0.02 / 120.0)] * 2)
    np.testing.assert_allclose(after.statistics, metrics * faded, rtol=1e-14)  # roundings


def test_each_robot_mixes_in_a_tenth_of_the_difference_to_each_heard_robot() -> None:
    star = Edges(np.arange(2), np.array([0, 0, 1]), np.array([1, 2, 0]))
    before = ReceptionFit(POOLED, np.array([[1.0] * STATISTICS, [5.0] * STATISTICS]), np.zeros(2), np.ones(2))
    theirs = np.array([[5.0] * STATISTICS, [9.0] * STATISTICS, [1.0] * STATISTICS])
    heard = np.array([True, False, True])
    after = packet_counting.mix(before, star, heard, theirs)
    np.testing.assert_allclose(
        after.statistics, [[1.4] * STATISTICS, [4.6] * STATISTICS], rtol=1e-14
    )  # 1 + 0.1 (5 - 1), 5 + 0.1 (1 - 5)
    crowd = Edges(np.arange(1), np.zeros(19, dtype=np.int64), np.arange(1, 20))
    mixed = packet_counting.mix(
        ReceptionFit(POOLED, np.zeros((1, STATISTICS)), np.zeros(1), np.ones(1)),
        crowd,
        np.ones(19, dtype=np.bool_),
        np.full((19, STATISTICS), 20.0),
    )
    np.testing.assert_allclose(
        mixed.statistics, [[19.0] * STATISTICS], rtol=1e-14
    )  # 19 of 20 parts: no robot gives more than all that it has


def test_bounds_of_estimates_grow_with_the_objective() -> None:
    estimates, wide = (
        np.array([1.0, 80.0, 400.0]),
        ObjectiveConfig(minimum_separation=200.0, maximum_separation=300.0),
    )
    assert packet_counting.bounded(estimates, ObjectiveConfig()).tolist() == [20.0, 80.0, 145.0]
    assert packet_counting.bounded(estimates, wide).tolist() == [40.0, 80.0, 290.0]


def test_robots_at_the_same_point_learn_finite_values() -> None:
    known = packet_counting.learn(
        packet_counting.no_counts(POOLED, 1), np.array([0]), np.array([0.0]), np.array([True]), 75.0
    )
    assert np.isfinite(known.statistics).all()
    assert np.isfinite(known.exponent).all()


def test_the_curvature_of_the_preference_is_the_derivative_of_its_slope() -> None:
    r, h = np.linspace(20.0, 145.0, 60), 1e-4
    for team_objective in (ObjectiveConfig(), ObjectiveConfig(minimum_separation=100.0, shape_exponent=3.0)):
        rise = objective.log_preference_slope(r + h, team_objective) - objective.log_preference_slope(
            r - h, team_objective
        )
        # central differences: h^2 times the third derivative, and 1e-16/h of rounding
        np.testing.assert_allclose(
            objective.log_preference_derivatives(r, team_objective)[1], rise / (2.0 * h), atol=1e-10
        )


def test_links_without_pooling_learn_their_own_slope_and_keep_it_while_others_open_and_close() -> None:
    """Two links with exponents 1 and 6 at their own separations; then the first goes and a third comes."""
    rng, scale, slopes = np.random.default_rng(7), 75.0, np.array([1.0, 6.0])
    known = packet_counting.no_counts(ALONE, 2)
    for _ in range(6000):
        r = rng.uniform(60.0, 90.0, 2)
        decoded = rng.random(2) < np.exp(-0.3 * (r / scale) ** slopes)
        known = packet_counting.learn(known, np.arange(2), r, decoded, scale)
    # 6,000 samples at p = 0.74, (u - mean)^2 = 0.0135: sigma of the slope is 0.19, and the prior takes 0.02
    assert known.exponent == pytest.approx(slopes, abs=0.6)
    before, after = layouts.edges([0], [(0, 1), (0, 2)]), layouts.edges([0], [(0, 2), (0, 3)])
    carried = packet_counting.carry(known, before, after)
    assert carried.statistics[0].tolist() == known.statistics[1].tolist()
    assert carried.exponent[0] == known.exponent[1]
    assert carried.statistics[1].tolist() == [0.0] * STATISTICS
    assert packet_counting.carry(known, before, before) is known


def test_a_sample_of_the_index_is_the_preference_if_the_beacon_decoded_and_zero_otherwise() -> None:
    near, team_objective = layouts.edges([0], [(0, 1), (0, 2)]), ObjectiveConfig()
    before, now, receiver = contacts.no_contacts(near.ids, 0, 0), contacts.no_contacts(near.ids, 0, 0), Receiver()
    here = layouts.poses([(0.0, 0.0)])
    for tick, codes in ((4, [2, 2]), (5, [2, 1])):  # at first both decode: a peer that was never heard has no link
        beacons = layouts.silent_beacons(tick - 1, np.array([1, 2]), layouts.poses([(60.0, 0.0), (0.0, 70.0)]))
        sensed = Observations(tick, here, near, np.array(codes, dtype=np.uint8))
        before, now = now, layouts.heard(now, receiver, sensed, here, beacons)
    around = Neighborhood(5, 0.02, here, now, before, now.edges, np.arange(2))
    sample = seeking_perturbation.sample(around, laws.context(near.ids))
    assert sample.tolist() == [objective.preference(np.array([60.0]), team_objective)[0], 0.0]


def test_the_dithers_of_links_that_learn_alone_are_staggered_equally_at_both_ends() -> None:
    config = MeasuredConfig(index="measured", dither_frequency=0.5)
    pairs = [(i, j) for i in range(30) for j in range(30) if i != j]
    links = layouts.edges(range(30), pairs)
    ahead = link_estimates.stagger(config, SeededDraws(3), links)
    assert (ahead == ahead[links.reverse]).all()
    part = ahead / (2.0 * np.pi / 0.5)
    # 435 uniform numbers: 4 sigma of their mean
    assert part.mean() == pytest.approx(0.5, abs=4.0 / np.sqrt(12.0 * 435.0))
    assert (part >= 0.0).all()
    assert (part < 1.0).all()
    assert not np.allclose(ahead, link_estimates.stagger(config, SeededDraws(4), layouts.edges(range(30), pairs)))
