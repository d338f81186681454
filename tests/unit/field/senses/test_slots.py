"""Slots of a peer: over any drift, jitter, loss and order, each beacon counts once, and nothing is falsely lost."""

import pytest

from field.senses.slot_counts import SlotCounts
from field.senses.slots import Heard, Slots
from tests.support.two_clocks import BOOT, Peer, beacon

HOUR = 180_000
"""Ticks of 20 ms."""

TEN_MILLISECONDS = 0.5
"""[ticks]"""


def counted(peer: Peer, steps: int) -> tuple[SlotCounts, int, int]:
    """The counts after `steps` own steps, and two numbers of beacons from the first heard until the last step: those
    that the peer sent, and those that arrived."""
    counts, slots, arrived = SlotCounts(), None, 0
    arrivals = iter(peer.arrivals(steps + steps // 1000 + 10, seed=1))
    at, sent = next(arrivals)
    sent_before = sent - peer.first
    for tick in range(1, steps):
        while at < tick:
            heard = Heard(beacon(sent), at)
            if slots is None:
                slots = Slots(BOOT, sent, heard, counts)
            slots.hear(sent, heard, tick - 1)
            arrived += 1
            at, sent = next(arrivals)
        if slots is not None and slots.begin < tick:
            slots.take(tick)
    return counts, int((steps - 1 - peer.phase) / (1.0 + peer.drift)) + 1 - sent_before, arrived


@pytest.mark.parametrize("drift", [1e-4, -1e-4], ids=["slower peer", "faster peer"])
def test_clocks_a_hundred_ppm_apart_lose_nothing_in_an_hour(drift: float) -> None:
    """They drift apart by 18 ticks, each of them a change of the offset, and the start may cost one more.

    The bound for slots that are falsely lost is 0. The low quantile of a window is at least
    LEAST, half of the jitter. The least slack is below it by less, unless 47 of 50 delays are in the lower half.
    """
    counts, _, arrived = counted(Peer(phase=0.37, first=1000, drift=drift, jitter=TEN_MILLISECONDS), HOUR)
    assert (counts.missed, counts.late, counts.early, counts.skipped, counts.unsent) == (0, 0, 0, 0, 0)
    changes, other = (counts.inserted, counts.removed) if drift > 0 else (counts.removed, counts.inserted)
    assert 17 <= changes <= 19
    assert other <= 1
    assert 0 <= arrived - counts.heard - counts.removed <= 2  # waiting at the end


def test_the_losses_of_a_channel_are_counted_one_for_one_while_clocks_drift() -> None:
    peer, steps = Peer(phase=0.9, drift=1e-4, jitter=TEN_MILLISECONDS, loss=0.6), HOUR // 5
    counts, sent, arrived = counted(peer, steps)
    assert counts.late == 0
    assert 3 <= counts.inserted <= 4
    assert abs(counts.missed - (sent - arrived)) <= 3  # the last ones wait for their steps


def slots_of(first: float, ticks: int = 1) -> tuple[Slots, SlotCounts]:
    """Slots of a peer whose ticks 0 to `ticks` - 1 arrive one own tick apart, the first at `first`."""
    counts = SlotCounts()
    slots = Slots(BOOT, 0, Heard(beacon(0), first), counts)
    for tick in range(ticks):
        slots.hear(tick, Heard(beacon(tick), first + tick), stepped=int(first) + tick)
        if slots.begin < int(first) + tick + 1:
            slots.take(int(first) + tick + 1)
    return slots, counts


@pytest.mark.parametrize("first", [4.0, 4.3, 4.999])
def test_the_first_beacon_is_used_after_a_whole_tick_of_patience(first: float) -> None:
    slots, _ = slots_of(first)
    assert slots.begin == 5
    taken = slots.take(6)
    assert taken is not None
    assert taken.beacon.tick == 0


def test_a_beacon_that_comes_after_its_slot_is_late_and_has_no_effect() -> None:
    slots, counts = slots_of(4.5)
    slots.take(6)
    slots.hear(1, Heard(beacon(1), 7.1), stepped=6)  # slot 6: step 7 is still to come
    assert slots.take(7) is not None
    slots.hear(2, Heard(beacon(2), 8.1), stepped=8)  # slot 7: step 8 has passed
    assert (counts.late, counts.heard) == (1, 2)
    assert slots.take(8) is None
    assert counts.missed == 1


def test_a_slot_is_not_filled_twice() -> None:
    slots, counts = slots_of(4.5)
    slots.hear(0, Heard(beacon(0), 4.6), stepped=4)
    slots.take(6)
    slots.hear(0, Heard(beacon(0), 6.1), stepped=6)
    assert (counts.repeated, counts.heard, counts.late) == (2, 1, 0)


def test_ticks_that_a_peer_did_not_send_are_told_from_losses_by_its_sequence() -> None:
    slots, counts = slots_of(4.5)
    slots.hear(1, Heard(beacon(4), 8.5), stepped=8)  # four ticks later, but the next number: three were not sent
    assert counts.unsent == 3
    slots.hear(4, Heard(beacon(7), 11.5), stepped=11)  # three ticks and three numbers later: two were lost
    assert counts.unsent == 3


def test_beacons_of_slots_that_the_robot_skipped_are_dropped() -> None:
    slots, counts = slots_of(4.5)
    for tick in (1, 2, 3):
        slots.hear(tick, Heard(beacon(tick), 4.5 + tick), stepped=4)
    taken = slots.take(9)
    assert taken is not None
    assert taken.beacon.tick == 3
    assert (counts.skipped, counts.heard) == (3, 1)


@pytest.mark.parametrize("jump", [40, -40])
def test_a_peer_whose_ticks_jump_is_in_step_again_after_two_windows(jump: int) -> None:
    slots, counts = slots_of(4.5, 60)
    for tick in range(60, 300):
        step = 4 + tick
        slots.hear(tick, Heard(beacon(tick + jump), 4.5 + tick), stepped=step)
        slots.take(step + 1)
    heard = counts.heard
    for tick in range(300, 350):
        slots.hear(tick, Heard(beacon(tick + jump), 4.5 + tick), stepped=4 + tick)
        assert slots.take(5 + tick) is not None
    assert counts.heard == heard + 50
    assert counts.missed <= 101 + abs(jump)
    assert counts.late + counts.early >= 1
