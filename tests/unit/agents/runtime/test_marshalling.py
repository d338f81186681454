"""Messages to arrays and back: a crew's words come out of their payloads to the bit."""

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from agents.runtime.marshalling import MessageAssembler, encode_tick
from fes.arrays.types import Bytes, Floats, Ints
from fes.model.sensing import MAX_NUMBER, MAX_TWIST, Beacons, Telemetry, bounded
from fes.protocol import messages
from fes.protocol.messages import Beacon, Observation
from tests.support import layouts

Pairs = set[tuple[int, int]]

IDS = (0, 3, 4, 90, 2**31 - 1)
crews = st.sets(st.sampled_from(IDS), min_size=1)
pair_sets = st.sets(st.tuples(st.sampled_from(IDS), st.sampled_from(IDS)).filter(lambda pair: pair[0] != pair[1]))
seeds = st.integers(0, 2**32)


def wild(rng: np.random.Generator, *shape: int, most: float = MAX_NUMBER) -> Floats:
    """Numbers within `most` of zero, of every bit pattern: both zeros, subnormal ones, the largest."""
    numbers = rng.integers(0, 2**64, shape, dtype=np.uint64, endpoint=False).view(np.float64)
    kept = np.where(np.isfinite(numbers) & (rng.random(shape) < 0.8), numbers, -0.0)
    return bounded(kept, most)


def say(crew: set[int], pairs: Pairs, seed: int, tick: int = 7) -> tuple[Beacons, Floats]:
    """The beacons of a crew with these links, and its twists."""
    rng = np.random.default_rng(seed)
    links = layouts.edges(crew, {pair for pair in pairs if pair[0] in crew})
    selected = rng.random(len(links)) < 0.5
    poses, estimates, statistics = wild(rng, len(crew), 3), wild(rng, len(links)), wild(rng, len(crew), 5)
    declared = rng.integers(0, 256, (len(crew), 4), dtype=np.uint8)
    beacons = Beacons(tick, links.ids, poses, links, estimates, selected, statistics, declared)
    return beacons, wild(rng, len(crew), 2, most=MAX_TWIST)


def told(said: Beacons, learnt: Floats) -> Telemetry:
    """The telemetry of a crew with healthy transmitters; its details are x and -y of each robot."""
    details = said.poses[:, :2] * np.array([1.0, -1.0])
    return Telemetry(said.links, said.estimates, learnt, details)


def sent(said: Beacons, twists: Floats) -> list[Beacon]:
    """The crew's beacons, each decoded from its payload."""
    return [
        messages.decode_beacon(beacon) for _, beacon, _ in encode_tick(said, twists, told(said, np.zeros((2, 0))))
    ]


def bits(array: Floats | Ints | Bytes) -> tuple[str, tuple[int, ...], bytes]:
    return array.dtype.str, array.shape, array.tobytes()


@given(crew=crews, pairs=pair_sets, seed=seeds)
def test_beacons_split_into_payloads_and_stacked_again_are_the_same_bits(
    crew: set[int], pairs: Pairs, seed: int
) -> None:
    beacons, twists = say(crew, pairs, seed)
    again = MessageAssembler(beacons.ids).beacons(7, sent(beacons, twists))
    assert again.tick == beacons.tick
    for name in ("ids", "poses", "estimates", "selected", "statistics", "declared"):
        assert bits(getattr(again, name)) == bits(getattr(beacons, name)), name
    for name in ("ids", "rows", "peers"):
        assert bits(getattr(again.links, name)) == bits(getattr(beacons.links, name)), name


@given(crew=crews, pairs=pair_sets, seed=seeds)
def test_each_command_holds_its_own_robots_twist_and_telemetry(crew: set[int], pairs: Pairs, seed: int) -> None:
    beacons, twists = say(crew, pairs, seed)
    estimates = dict(zip(sorted(layouts.pairs_of(beacons.links)), beacons.estimates.tolist(), strict=True))
    learnt = np.stack([beacons.estimates, -beacons.estimates])
    for index, (robot, _, payload) in enumerate(encode_tick(beacons, twists, told(beacons, learnt))):
        command = messages.decode_command(payload)
        assert (command.robot, command.tick, robot) == (sorted(crew)[index], 7, sorted(crew)[index])
        assert bits(command.learnt) == bits(np.concatenate([command.estimates, -command.estimates]))
        assert bits(command.details) == bits(beacons.poses[index, :2] * np.array([1.0, -1.0]))
        assert np.array(command.twist).tobytes() == twists[index].tobytes()
        peers = sorted(peer for own, peer in pairs if own == robot)
        assert command.links.tolist() == peers
        assert command.estimates.tolist() == [estimates[robot, peer] for peer in peers]


def test_the_edges_are_the_same_object_while_no_link_changes() -> None:
    crew, pairs = {0, 3, 90}, {(0, 3), (3, 0), (3, 90)}
    stack = MessageAssembler(np.array([0, 3, 90]))
    first, moved, changed = (
        stack.beacons(tick, sent(*say(crew, links, seed=tick, tick=tick)))
        for tick, links in ((1, pairs), (2, pairs), (3, pairs - {(3, 90)}))
    )
    assert moved.links is first.links
    assert moved.ids is first.ids
    assert bits(moved.poses) != bits(first.poses)
    assert changed.ids is first.ids
    assert changed.links is not first.links
    assert layouts.pairs_of(changed.links) == {(0, 3), (3, 0)}


def test_a_sender_that_falls_silent_makes_new_edges_without_it() -> None:
    crew, pairs = {0, 3, 90}, {(0, 3), (3, 0), (90, 3)}
    stack, heard = MessageAssembler(np.array([0, 3, 90])), sent(*say(crew, pairs, seed=1))
    complete, part = stack.beacons(7, heard), stack.beacons(7, heard[:2])
    assert part.links is not complete.links
    assert part.ids.tolist() == [0, 3]
    assert layouts.pairs_of(part.links) == {(0, 3), (3, 0)}


def test_a_tick_without_beacons_is_silence() -> None:
    nothing = MessageAssembler(np.array([5])).beacons(7, [])
    assert (len(nothing.ids), len(nothing.links), nothing.poses.shape) == (0, 0, (0, 3))


def test_observations_are_decoded_in_id_order_and_keep_their_edges_while_no_peer_enters_or_leaves() -> None:
    stack = MessageAssembler(np.array([3, 8]))

    def sense(tick: int, near: list[int]) -> list[Observation]:
        codes = np.full(len(near), 2, dtype=np.uint8)
        first = Observation(tick, 3, (1.0, -0.0, math.pi), np.array(near), codes, over=False, since=0)
        second = first._replace(robot=8, pose=(5.0, 6.0, 7.0), in_range=near_ids(3))
        second = second._replace(reception=np.array([1], dtype=np.uint8))
        return [
            messages.decode_observation(messages.encode_observation(observation)) for observation in (first, second)
        ]

    first, again, changed = (stack.observations(sense(tick, near)) for tick, near in CASES)
    assert (first.tick, again.tick) == (4, 5)
    assert bits(first.poses) == bits(np.array([[1.0, -0.0, math.pi], [5.0, 6.0, 7.0]]))
    assert layouts.pairs_of(first.in_range) == {(3, 4), (3, 9), (8, 3)}
    assert first.reception.tolist() == [2, 2, 1]
    assert again.in_range is first.in_range
    assert changed.in_range is not first.in_range
    assert layouts.pairs_of(changed.in_range) == {(3, 4), (8, 3)}


CASES = ((4, [4, 9]), (5, [4, 9]), (6, [4]))


def near_ids(*ids: int) -> Ints:
    return np.array(ids, dtype=np.int64)
