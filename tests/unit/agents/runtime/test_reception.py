"""The verdict of the radio, applied: what a crew gets of its peers, against plain sets of pairs."""

import math
from collections.abc import Collection
from dataclasses import replace

import numpy as np
import pytest

from agents.runtime import reception
from agents.runtime.reception import Receiver
from fes.arrays.edges import Edges, no_edges
from fes.model.sensing import CLOSED, DECODED, LOST, Beacons, Observations, Received, no_beacons
from tests.support import layouts

IDS = np.arange(4)
WHERE = layouts.poses([(0.0, 0.0), (30.0, 40.0), (-60.0, 80.0), (5.0, 5.0)])
EVERY = {(i, j) for i in range(4) for j in range(4) if i != j}
Pairs = set[tuple[int, int]]

SECRET = 123456.0
"""A number that only the beacon of robot 2 contains."""


def sent(tick: int, links: Collection[tuple[int, int]] = ()) -> Beacons:
    """The beacons of all robots; link (i, j) has the estimate 10 i + j, and is selected if i < j."""
    edges = layouts.edges(range(4), links)
    estimates = (10 * edges.robots + edges.peers).astype(np.float64)
    statistics = np.column_stack([IDS + 0.5, 2.0 * IDS])
    declared = np.column_stack([IDS, IDS + 100, IDS + 200]).astype(np.uint8)
    return Beacons(tick, IDS, WHERE, edges, estimates, edges.robots < edges.peers, statistics, declared)


def without(beacons: Beacons, *gone: int) -> Beacons:
    """The beacons, of which those of some robots did not arrive."""
    keeps, links = ~np.isin(beacons.ids, gone), beacons.links
    among = ~np.isin(links.robots, gone)
    ids = beacons.ids[keeps]
    return Beacons(
        beacons.tick,
        ids,
        beacons.poses[keeps],
        Edges(ids, np.searchsorted(ids, links.robots[among]), links.peers[among]),
        beacons.estimates[among],
        beacons.selected[among],
        beacons.statistics[keeps],
        beacons.declared[keeps],
    )


def sensed(tick: int, near: Edges, decoded: Pairs) -> Observations:
    """Observations of the robots of `near`, at which the beacons of the pairs `decoded` (robot, peer) decoded."""
    pairs = zip(near.robots.tolist(), near.peers.tolist(), strict=True)
    codes = np.array([DECODED if pair in decoded else LOST for pair in pairs], dtype=np.uint8)
    return Observations(tick, WHERE[near.ids], near, codes)


def near_of(robots: set[int], pairs: Pairs = EVERY) -> Edges:
    """The peers in range of the robots of a crew."""
    return layouts.edges(robots, {pair for pair in pairs if pair[0] in robots})


def heard(received: Received) -> Pairs:
    """The pairs (robot, peer) whose beacon a crew received."""
    edges, at = received.edges, received.heard
    return set(zip(edges.robots[at].tolist(), edges.peers[at].tolist(), strict=True))


def numbers(received: Received) -> list[float]:
    """Every number in what a crew received, except ids and positions."""
    arrays = (
        received.x,
        received.y,
        received.heading,
        received.estimates,
        received.statistics,
        received.declared,
        received.mean_estimates(),
    )
    return [float(number) for array in arrays for number in np.asarray(array, dtype=np.float64).ravel()]


@pytest.mark.parametrize("code", [CLOSED, LOST])
def test_a_beacon_that_did_not_decode_leaves_no_trace(code: int) -> None:
    beacons = sent(6, links={(2, 0), (2, 1), (1, 0)})
    beacons.poses[2] = SECRET
    beacons.statistics[2] = SECRET
    beacons.estimates[beacons.links.robots == 2] = SECRET
    near = near_of({0})
    codes = np.array([DECODED, code, DECODED], dtype=np.uint8)
    crew = Observations(7, WHERE[:1], near, codes)
    received = Receiver().receive(crew, beacons, no_edges(np.array([0])))
    assert layouts.pairs_of(received.edges) == heard(received) == {(0, 1), (0, 3)}
    assert SECRET not in numbers(received)
    # and the same to the bit as if it had never been sent
    never = Receiver().receive(crew, without(beacons, 2), no_edges(np.array([0])))
    assert heard(never) == heard(received)
    np.testing.assert_array_equal(numbers(never), numbers(received))


def test_a_beacon_is_received_with_all_its_content() -> None:
    beacons = sent(6, links={(0, 1), (1, 0), (1, 2), (2, 0), (3, 1)})
    received = Receiver().receive(sensed(7, near_of({0, 1}), EVERY), beacons, no_edges(IDS[:2]))
    assert received.tick == 6
    assert heard(received) == {(0, 1), (0, 2), (0, 3), (1, 0), (1, 2), (1, 3)}
    senders = [1, 2, 3, 0, 2, 3]
    assert np.stack([received.x, received.y, received.heading], axis=1).tolist() == WHERE[senders].tolist()
    # the sender's estimate for its link to this robot, and nothing of its other links
    nan = math.nan
    np.testing.assert_array_equal(received.estimates, [10.0, 20.0, nan, 1.0, nan, 31.0])
    assert received.selected.tolist() == [False, False, False, True, False, False]
    assert received.statistics.tolist() == [[sender + 0.5, 2.0 * sender] for sender in senders]
    assert received.declared.tolist() == [[sender, sender + 100, sender + 200] for sender in senders]
    means = [11.0, 20.0, 31.0, 1.0, 20.0, 31.0]  # robot 1 has the links to 0 and 2: (10 + 12) / 2
    assert received.mean_estimates().tolist() == means


def test_a_peer_in_range_becomes_a_contact_with_its_first_decoded_beacon_and_remains_one_while_in_range() -> None:
    receiver, near, contacts = Receiver(), near_of({0}), no_edges(IDS[:1])
    history = []
    for tick, decoded in enumerate([set(), {(0, 2)}, set(), {(0, 1)}, {(0, 2), (0, 3)}, set()], 1):
        received = receiver.receive(sensed(tick, near, decoded), sent(tick - 1), contacts)
        contacts = received.edges
        assert heard(received) == decoded
        history.append(contacts.peers.tolist())
    assert history == [[], [2], [2], [1, 2], [1, 2, 3], [1, 2, 3]]


def test_a_peer_out_of_range_is_dropped_and_must_be_heard_again() -> None:
    receiver, contacts = Receiver(), no_edges(IDS[:1])
    contacts = receiver.receive(sensed(1, near_of({0}), EVERY), sent(0), contacts).edges
    away = near_of({0}, EVERY - {(0, 2)})
    contacts = receiver.receive(sensed(2, away, set()), sent(1), contacts).edges
    assert contacts.peers.tolist() == [1, 3]
    back = near_of({0})
    contacts = receiver.receive(sensed(3, back, {(0, 1)}), sent(2), contacts).edges
    assert contacts.peers.tolist() == [1, 3]
    contacts = receiver.receive(sensed(4, back, {(0, 2)}), sent(3), contacts).edges
    assert contacts.peers.tolist() == [1, 2, 3]


def test_in_a_crew_each_contact_is_made_by_its_own_robots_verdict() -> None:
    near = near_of({0, 1, 3})
    decoded = {(0, 2), (1, 0), (3, 1), (3, 2)}
    received = Receiver().receive(sensed(5, near, decoded), sent(4), no_edges(np.array([0, 1, 3])))
    assert heard(received) == layouts.pairs_of(received.edges) == decoded
    alone = [
        heard(Receiver().receive(sensed(5, near_of({robot}), decoded), sent(4), no_edges(np.array([robot]))))
        for robot in (0, 1, 3)
    ]
    assert set().union(*alone) == decoded


def test_the_edges_are_the_same_object_while_the_pairs_are_the_same() -> None:
    receiver, near = Receiver(), near_of({0, 1})
    contacts = no_edges(near.ids)
    first = receiver.receive(sensed(1, near, {(0, 1), (1, 2)}), sent(0), contacts).edges
    for tick, decoded in enumerate([{(0, 1)}, set(), {(0, 1), (1, 2)}], 2):
        assert receiver.receive(sensed(tick, near, decoded), sent(tick - 1), first).edges is first
    # another object with the same peers in range, and a peer out of range that had not been heard
    for again in (near_of({0, 1}), near_of({0, 1}, EVERY - {(0, 3)})):
        assert receiver.receive(sensed(5, replace(again, ids=near.ids), set()), sent(4), first).edges is first
    more = receiver.receive(sensed(6, near, {(1, 3)}), sent(5), first).edges
    assert more is not first
    assert layouts.pairs_of(more) == {(0, 1), (1, 2), (1, 3)}


def test_with_all_peers_heard_the_contacts_are_the_pairs_in_range_themselves() -> None:
    near = near_of({0, 1})
    received = Receiver().receive(sensed(1, near, EVERY), sent(0), no_edges(near.ids))
    assert received.edges is near


def test_a_beacon_that_decoded_but_did_not_arrive_counts_as_not_heard() -> None:
    near, contacts = near_of({0}), no_edges(IDS[:1])
    observations = sensed(3, near, {(0, 1), (0, 2)})
    received = Receiver().receive(observations, without(sent(2), 2), contacts)
    assert heard(received) == layouts.pairs_of(received.edges) == {(0, 1)}
    assert reception.absent(observations, []) == [1, 2]
    assert reception.absent(observations, [2, 7]) == [1]
    assert reception.absent(observations, [2, 1]) == []
    assert reception.missing(observations, [0, 1, 3]) == 1
    assert reception.missing(observations, [1, 2]) == 0
    assert heard(Receiver().receive(observations, no_beacons(), contacts)) == set()


def test_missing_counts_each_robot_at_which_the_beacon_decoded() -> None:
    observations = sensed(3, near_of({0, 1}), {(0, 2), (1, 2), (1, 0)})
    assert reception.absent(observations, []) == [0, 2]
    assert reception.missing(observations, [0]) == 2
    assert reception.missing(observations, []) == 3


@pytest.mark.parametrize("seed", range(20))
def test_over_any_history_the_contacts_are_those_of_the_definition_with_and_without_a_cache(seed: int) -> None:
    """Ranges, losses and late beacons at random; a new receiver in every tick has no cache."""
    rng, robots, n = np.random.default_rng(seed), {0, 2, 3}, 4
    receiver, near = Receiver(), near_of(robots)
    contacts, expected = no_edges(near.ids), set[tuple[int, int]]()
    for tick in range(1, 40):
        if rng.random() < 0.3:
            kept = {pair for pair in EVERY if rng.random() < 0.8}
            near = replace(near_of(robots, kept), ids=near.ids)
        decoded = {pair for pair in EVERY if rng.random() < 0.3}
        gone = {robot for robot in range(n) if rng.random() < 0.1}
        observations, beacons = sensed(tick, near, decoded), without(sent(tick - 1, links={(0, 1), (2, 0)}), *gone)
        fresh = Receiver().receive(observations, beacons, contacts)
        received = receiver.receive(observations, beacons, contacts)
        in_range = layouts.pairs_of(near)
        arrived = {pair for pair in decoded & in_range if pair[1] not in gone}
        changed, expected = expected, (expected & in_range) | arrived
        assert layouts.pairs_of(received.edges) == layouts.pairs_of(fresh.edges) == expected
        assert heard(received) == heard(fresh) == arrived
        np.testing.assert_array_equal(numbers(received), numbers(fresh))
        assert (received.edges is contacts) == (changed == expected)
        contacts = received.edges
