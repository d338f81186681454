"""Observations from beacons heard: labels, range, restarts, and no effect of repeats and order."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fes.model.sensing import DECODED, LOST
from fes.protocol.messages import Observation, decode_observation, encode_observation
from fes.protocol.sealed import Sealed
from field.senses.senses import Senses, arrival
from tests.support.two_clocks import BOOT, PEER, ROBOT, Peer, beacon, handed

MEMORY, FOREVER = 20, 10**9

phases, jitters = st.floats(0.0, 0.999), st.floats(0.0, 0.99)
losses, seeds = st.floats(0.0, 0.9), st.integers(0, 1000)


def hear(senses: Senses, tick: int, at: float, peer: int = PEER, boot: int = BOOT) -> None:
    senses.hear(Sealed(peer, boot, tick, b""), beacon(tick, peer), at)


def step(senses: Senses, tick: int) -> tuple[Observation, list[int]]:
    """The observation of a step, and the beacons' first coordinate, which is the tick of their sender."""
    observation, beacons = senses.step(tick, (1.0, 2.0, 3.0), tick, 0)
    assert [message.tick for message in beacons] == [tick - 1] * len(beacons)
    return observation, [int(message.pose[0]) for message in beacons]


@given(phases, jitters, losses, seeds, st.integers(0, 10**6))
def test_each_step_gets_the_newest_beacon_with_the_number_of_the_tick_before(
    phase: float, jitter: float, loss: float, seed: int, first: int
) -> None:
    arrivals = Peer(phase, first, jitter=jitter, loss=loss).arrivals(40, seed)
    for tick, beacons in handed(Senses(ROBOT, FOREVER), arrivals, 44):
        newest = max((sent for time, sent in arrivals if time < tick), default=None)
        assert len(beacons) <= 1
        assert all((beacon.tick, int(beacon.pose[0])) == (tick - 1, newest) for beacon in beacons)


@given(phases, st.floats(0.0, 3.0), losses, seeds)
def test_repeated_beacons_change_nothing(phase: float, jitter: float, loss: float, seed: int) -> None:
    once = Peer(phase, 0, jitter=jitter, loss=loss).arrivals(200, seed)
    twice = sorted([*once, *((at + 3.0 * jitter, tick) for at, tick in once)])
    plain, repeated = (list(handed(Senses(ROBOT, FOREVER), arrivals, 210)) for arrivals in (once, twice))
    assert [[message.pose for message in beacons] for _, beacons in plain] == [
        [message.pose for message in beacons] for _, beacons in repeated
    ]


@given(phases, st.floats(0.0, 3.0), losses, seeds, st.floats(-2e-3, 2e-3))
def test_the_pose_of_a_peer_never_goes_back_in_time(
    phase: float, jitter: float, loss: float, seed: int, drift: float
) -> None:
    senses = Senses(ROBOT, FOREVER)
    arrivals = Peer(phase, 0, drift, jitter, loss, repeats=0.2).arrivals(400, seed)
    used = [int(message.pose[0]) for _, beacons in handed(senses, arrivals, 420) for message in beacons]
    assert used == sorted(used)


def test_a_peer_is_in_range_until_it_has_been_silent_for_the_memory_and_its_beacon_serves_for_a_quarter() -> None:
    senses = Senses(ROBOT, MEMORY)
    hear(senses, 100, at=4.5)
    observed = [step(senses, tick)[0] for tick in range(5, 40)]
    in_range = [observation.tick for observation in observed if observation.in_range.tolist() == [PEER]]
    assert in_range == list(range(6, 25))
    codes = [observation.reception.tolist() for observation in observed]
    assert codes[:6] == [[], *[[DECODED]] * 4, [LOST]]
    assert codes[-1] == []
    counts = senses.counts[PEER]
    assert (counts.heard, counts.missed, counts.concealed, counts.stale) == (1, 0, 18, 15)


def test_a_peer_heard_again_after_a_silence_begins_anew() -> None:
    senses = Senses(ROBOT, MEMORY)
    hear(senses, 100, at=4.5)
    hear(senses, 500, at=104.5)
    step(senses, 105)
    assert step(senses, 106)[1] == [500]
    assert senses.counts[PEER].starts == 2


def test_a_restarted_peer_begins_anew_at_once() -> None:
    senses = Senses(ROBOT, MEMORY)
    hear(senses, 100, at=4.5)
    step(senses, 5)
    hear(senses, 0, at=5.5, boot=BOOT + 1)
    step(senses, 6)
    assert step(senses, 7)[1] == [0]
    assert senses.counts[PEER].starts == 2


def test_a_robot_that_starts_anew_counts_no_beacon_that_was_sent_while_it_did_not_listen() -> None:
    senses = Senses(ROBOT, MEMORY)
    for tick in range(1, 6):
        hear(senses, tick, at=tick - 0.5)
        senses.step(tick, (1.0, 2.0, 3.0), tick, 1)
    observed = []
    for tick in range(16, 30):  # stopped for ten ticks, less than the memory
        observation, _ = senses.step(tick, (1.0, 2.0, 3.0), tick, 16)
        observed.append(observation.reception.tolist())
        hear(senses, tick, at=tick + 0.5)
    assert observed == [[], [], *[[DECODED]] * 12]
    counts = senses.counts[PEER]
    assert (counts.missed, counts.starts) == (0, 2)


def test_a_beacon_of_the_last_tick_is_fresh_however_short_the_memory() -> None:
    senses = Senses(ROBOT, 2)
    observed = []
    for tick in range(1, 8):
        hear(senses, tick, at=tick - 0.5)
        observed.append(step(senses, tick)[0].reception.tolist())
    assert observed == [[], *[[DECODED]] * 6]
    assert senses.counts[PEER].stale == 0


def test_peers_and_beacons_ascend_and_the_observation_is_a_valid_message() -> None:
    senses = Senses(ROBOT, MEMORY)
    for peer in (7, 2, 5):
        hear(senses, peer, at=0.5, peer=peer)
    hear(senses, 10, at=1.5, peer=2)
    step(senses, 1)
    assert step(senses, 2)[1] == [10, 5, 7]
    hear(senses, 9, at=2.5, peer=5)  # its numbers 6 to 8 were lost, as 3 to 9 of robot 2
    observation, sent = step(senses, 3)
    assert (observation.in_range.tolist(), sent) == ([2, 5, 7], [7])
    assert (observation.tick, observation.robot, observation.pose) == (3, ROBOT, (1.0, 2.0, 3.0))
    decoded = decode_observation(encode_observation(observation))
    assert decoded.reception.tolist() == [LOST, LOST, DECODED]
    assert step(senses, 4)[0].in_range is observation.in_range


def test_a_beacon_that_names_another_robot_than_its_datagram_has_no_effect() -> None:
    senses = Senses(ROBOT, MEMORY)
    senses.hear(Sealed(PEER, BOOT, 0, b""), beacon(0, PEER + 1), 0.5)
    senses.hear(Sealed(ROBOT, BOOT, 0, b""), beacon(0, ROBOT), 0.5)
    assert senses.foreign == 2
    assert not senses.counts


def test_a_tick_that_does_not_ascend_is_an_error() -> None:
    senses = Senses(ROBOT, MEMORY)
    step(senses, 5)
    with pytest.raises(ValueError, match="must ascend, got 5"):
        step(senses, 5)


def test_own_poses_at_reception_lie_between_the_steps() -> None:
    senses = Senses(ROBOT, MEMORY)
    senses.step(4, (4.0, 0.0, 0.0), 4, 0)
    hear(senses, 100, at=4.25)
    senses.step(5, (5.0, 0.0, 0.0), 5, 0)
    senses.step(6, (6.0, 0.0, 0.0), 6, 0)
    assert senses.poses_at_reception() == [pytest.approx((4.25, 0.0, 0.0))]


def test_an_arrival_in_own_ticks_is_its_time_over_the_tick() -> None:
    assert arrival(1_050_000_000, 1_000_000_000, 0.02) == pytest.approx(2.5)
