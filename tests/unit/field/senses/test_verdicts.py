"""Verdicts on a peer's beacons: with drift, jitter, pauses and any order, losses are those of the channel."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from field.senses.beacon_counts import BeaconCounts
from field.senses.verdicts import LONGEST, SPARE, WINDOW, Verdicts
from tests.support.two_clocks import Peer

HOUR = 180_000
"""Ticks of 20 ms."""


def judged(peer: Peer, steps: int, seed: int = 1) -> tuple[BeaconCounts, list[bool], int, int]:
    """The counts, all verdicts, and two numbers of beacons: those that the peer sent from the first one heard to the
    newest, and those of them that arrived."""
    counts, verdicts, given_, arrived = BeaconCounts(), None, list[bool](), 0
    first = newest = 0
    arrivals = iter(peer.arrivals(steps + steps // 1000 + 300, seed))
    time, sent = next(arrivals)
    for tick in range(1, steps):
        while time < tick:
            if verdicts is None:
                verdicts, first, newest = Verdicts(sent, counts), sent, sent
            else:
                verdicts.hear(sent)
            newest, arrived = max(newest, sent), arrived + 1
            time, sent = next(arrivals)
        if verdicts is not None:
            given_.append(verdicts.next())
    return counts, given_, newest - first + 1, arrived


def fed(sequences: list[int], ticks: int) -> tuple[Verdicts, BeaconCounts, list[bool]]:
    """Verdicts that have heard these numbers, all before the first of so many ticks."""
    counts = BeaconCounts()
    verdicts = Verdicts(sequences[0], counts)
    for sequence in sequences[1:]:
        verdicts.hear(sequence)
    return verdicts, counts, [verdicts.next() for _ in range(ticks)]


@pytest.mark.parametrize("drift", [1e-4, -1e-4], ids=["slower peer", "faster peer"])
def test_clocks_a_hundred_ppm_apart_lose_nothing_in_an_hour(drift: float) -> None:
    """They drift apart by 18 ticks: a slower peer has so many ticks concealed, and a faster one so many dropped."""
    counts, _, _, arrived = judged(Peer(phase=0.37, first=1000, drift=drift, jitter=0.5), HOUR)
    assert (counts.missed, counts.repeated) == (0, 0)
    changes, other = (counts.concealed, counts.dropped) if drift > 0 else (counts.dropped, counts.concealed)
    assert 16 <= changes <= 20
    assert other <= 2
    assert 0 <= arrived - counts.heard - counts.dropped <= 3  # waiting at the end


@pytest.mark.parametrize("pause", [0.0, 3.0, 12.0, 30.0])
@pytest.mark.parametrize("loss", [0.0, 0.05, 0.3, 0.6])
def test_the_share_of_losses_is_that_of_the_channel_also_while_the_network_pauses(loss: float, pause: float) -> None:
    """Within four standard deviations of a binomial sample, and each verdict is that of one beacon."""
    peer = Peer(phase=0.9, drift=1e-4, jitter=0.5, loss=loss, pause=pause)
    counts, verdicts, sent, arrived = judged(peer, HOUR // 5)
    own = counts.heard + counts.missed
    waiting = sent - own - counts.dropped
    assert counts.repeated == 0
    assert 0 <= waiting <= LONGEST
    assert 0 <= arrived - counts.heard <= counts.dropped + waiting
    spread = 4.0 * math.sqrt(loss * (1.0 - loss) / own)
    assert abs(counts.missed / own - loss) <= spread
    repeats = 1.0 + counts.concealed / own  # a repeated verdict adds to the spread
    assert abs(1.0 - sum(verdicts) / len(verdicts) - loss) <= spread * repeats


@given(st.floats(0.0, 10.0), st.floats(0.0, 0.9), st.integers(0, 1000))
def test_each_beacon_counts_at_most_once_in_any_order(jitter: float, loss: float, seed: int) -> None:
    counts, verdicts, sent, arrived = judged(Peer(0.4, jitter=jitter, loss=loss, repeats=0.2), 600, seed)
    assert counts.heard <= arrived
    assert counts.heard + counts.missed + counts.dropped <= sent
    assert len(verdicts) == counts.heard + counts.missed + counts.concealed


def test_a_beacon_tells_the_fate_of_those_before_it() -> None:
    _, counts, verdicts = fed([7, 8, 11], 5)
    assert verdicts == [True, True, False, False, True]
    assert (counts.heard, counts.missed, counts.concealed) == (3, 2, 0)


def test_a_tick_of_which_nothing_is_known_repeats_an_earlier_verdict_and_later_ones_wait() -> None:
    verdicts, counts, first = fed([0, 2], 5)
    assert first == [True, False, True, True, False]
    assert counts.concealed == 2
    verdicts.hear(3)
    verdicts.hear(5)
    assert [verdicts.next() for _ in range(3)] == [True, False, True]
    assert counts.concealed == 2


def test_a_beacon_in_another_order_replaces_the_loss_that_waits_and_a_second_one_counts_nothing() -> None:
    verdicts, counts, _ = fed([0, 3], 0)
    verdicts.hear(2)
    verdicts.hear(2)
    assert [verdicts.next() for _ in range(4)] == [True, False, True, True]
    assert counts.repeated == 1


def test_a_beacon_that_comes_after_it_counted_as_lost_makes_up_for_it_at_the_next_loss() -> None:
    verdicts, counts, first = fed([0, 2], 3)
    assert first == [True, False, True]
    verdicts.hear(1)
    verdicts.hear(5)
    assert [verdicts.next() for _ in range(3)] == [True, False, True]
    assert (counts.heard, counts.missed, counts.repeated) == (4, 2, 0)
    verdicts.hear(1)
    assert counts.repeated == 1


def test_verdicts_that_were_never_needed_are_dropped_after_a_window() -> None:
    verdicts, counts, _ = fed([0, *range(1, 10)], 1)
    for sequence in range(10, WINDOW + 9):
        verdicts.hear(sequence)
        verdicts.next()
    assert counts.dropped == 9 - SPARE
    assert counts.concealed == 0


def test_a_silence_leaves_no_more_verdicts_than_the_longest_queue() -> None:
    _, counts, verdicts = fed([0, 10_000], LONGEST)
    assert verdicts == [False] * (LONGEST - 1) + [True]
    assert counts.dropped == 2
