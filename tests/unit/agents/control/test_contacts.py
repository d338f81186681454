"""A robot's knowledge of its peers: from decoded beacons only, and only for a while."""

import math

import numpy as np
import pytest

from agents.control import contacts, crew
from agents.runtime.reception import Receiver
from fes.arrays.edges import Edges, no_edges
from fes.arrays.types import Floats
from fes.model.config import AgentConfig, ChannelConfig, FormationConfig, ObjectiveConfig
from fes.model.contacts import Contacts
from fes.model.seeking import OracleConfig
from fes.model.sensing import DECODED, LOST, Beacons, Observations
from tests.support import layouts, loop

IDS = np.arange(3)
ALL = layouts.edges(IDS, [(i, j) for i in range(3) for j in range(3) if i != j])
WHERE = layouts.poses([(0.0, 0.0), (30.0, 40.0), (-60.0, 80.0)])
TIMEOUT = 5


def hear(
    before: Contacts,
    tick: int,
    where: Floats,
    codes: list[int],
    near: Edges = ALL,
    links: Edges | None = None,
) -> Contacts:
    """The contacts at `tick` after the beacons of the tick before, sent from `where`."""
    linked = links or no_edges(IDS)
    estimates = np.array([60.0 + k for k in range(len(linked))])
    selected = np.array([k % 2 == 0 for k in range(len(linked))], dtype=np.bool_)
    blank = np.zeros((len(IDS), 0)), np.zeros((len(IDS), 0), dtype=np.uint8)
    beacons = Beacons(tick - 1, IDS, where, linked, estimates, selected, *blank)
    sensed = Observations(tick, where + 1.0, near, np.array(codes, dtype=np.uint8))
    return layouts.heard(before, Receiver(), sensed, where, beacons, TIMEOUT)


def test_separations_are_formed_from_two_poses_of_one_tick_and_equal_from_both_ends() -> None:
    where = layouts.scatter(np.random.default_rng(0), 3, 100.0)
    known = hear(contacts.no_contacts(IDS, 0, 0), 1, where, [DECODED] * 6)
    assert known.separation.tolist() == known.separation[ALL.reverse].tolist()  # to the bit
    expected = [math.dist(where[i, :2], where[j, :2]) for i, j in sorted(layouts.pairs_of(ALL))]
    assert known.separation == pytest.approx(expected, rel=1e-15)  # rounding


def test_the_content_of_a_lost_beacon_is_unknown() -> None:
    first = hear(contacts.no_contacts(IDS, 0, 0), 1, WHERE, [DECODED, LOST, DECODED, DECODED, LOST, DECODED])
    assert layouts.pairs_of(first.edges) == {(0, 1), (1, 0), (1, 2), (2, 1)}
    assert first.known.all()
    assert first.heard.tolist() == [0] * 4
    moved = WHERE + 10.0
    second = hear(first, 2, moved, [LOST, DECODED, LOST, LOST, LOST, DECODED])
    assert layouts.pairs_of(second.edges) == {(0, 1), (0, 2), (1, 0), (1, 2), (2, 1)}
    assert second.heard.tolist() == [0, 1, 0, 0, 1]
    # last heard places: robot 1 of tick 0, robot 2 of tick 1
    assert second.x[:2].tolist() == [30.0, -50.0]
    # from where robot 0 was at the tick of the beacon: (10, 10)
    assert (second.dx[1], second.dy[1]) == (-60.0, 80.0)


def test_a_peer_unheard_past_the_timeout_is_unknown_until_its_next_beacon() -> None:
    known = hear(contacts.no_contacts(IDS, 0, 0), 1, WHERE, [DECODED] * 6)
    history = []
    for tick in range(2, 9):
        known = hear(known, tick, WHERE, [LOST, DECODED, DECODED, DECODED, DECODED, DECODED])
        history.append(bool(known.known[0]))
        assert known.known[1:].all()
    assert history == [True] * 4 + [False] * 3  # heard at tick 0: known up to tick 5
    assert hear(known, 9, WHERE, [DECODED] * 6).known.all()


def test_a_peer_that_left_range_is_forgotten_and_the_others_are_not() -> None:
    known = hear(contacts.no_contacts(IDS, 0, 0), 1, WHERE, [DECODED] * 6)
    near = layouts.edges(IDS, [(0, 1), (1, 0)])
    without = hear(known, 2, WHERE, [LOST, LOST], near)
    assert without.heard.tolist() == [0, 0]
    lost = hear(without, 3, WHERE, [LOST] * 6)
    assert layouts.pairs_of(lost.edges) == {(0, 1), (1, 0)}
    assert lost.heard.tolist() == [0, 0]
    assert lost.known.all()
    back = hear(lost, 4, WHERE, [LOST, DECODED] * 3)
    assert layouts.pairs_of(back.edges) == {(0, 1), (0, 2), (1, 0), (1, 2), (2, 1)}
    assert back.heard.tolist() == [0, 3, 0, 3, 3]


def test_a_beacon_tells_each_receiver_only_the_estimate_and_choice_for_the_link_to_it() -> None:
    links = layouts.edges(IDS, [(0, 1), (1, 0), (1, 2)])  # estimates 60, 61, 62; named: yes, no, yes
    known = hear(contacts.no_contacts(IDS, 0, 0), 1, WHERE, [DECODED] * 6, links=links)
    # pairs (0,1), (0,2), (1,0), (1,2), (2,0), (2,1) hear of links (1,0), -, (0,1), -, -, (1,2)
    assert known.estimates == pytest.approx([61.0, math.nan, 60.0, math.nan, math.nan, 62.0], nan_ok=True)
    assert known.selected_by_peer.tolist() == [False, False, True, False, False, True]


def test_two_robots_at_the_same_point_drive_apart() -> None:
    config = AgentConfig(
        dt=0.02,
        seed=1,
        objective=ObjectiveConfig(),
        seeking=OracleConfig(),
        formation=FormationConfig(),
        channel=ChannelConfig(),
    )
    team = crew.create(config, np.arange(2))
    near = layouts.edges([0, 1], [(0, 1), (1, 0)])
    where = layouts.poses([(7.0, 7.0), (7.0, 7.0)])
    sensed = Observations(3, where, near, np.full(2, DECODED, dtype=np.uint8))
    beacons = layouts.silent_beacons(2, np.arange(2), where)
    state = crew.start(team)
    state = state._replace(poses=where)
    _, _, twists, _ = loop.tick(team, state, Receiver(), sensed, beacons)
    # psi_ji = pi + psi_ij: the lower id sees the other along +x and backs off; 50 to 90 m, weight 1/2
    assert np.isfinite(twists).all()
    assert -45.0 <= twists[0, 0] <= -25.0
    assert 25.0 <= twists[1, 0] <= 45.0
