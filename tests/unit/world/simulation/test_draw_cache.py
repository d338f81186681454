"""The radio's numbers, drawn ahead: those of each tick and pair, in any order of requests, in bounded memory."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fes.arithmetic import draws
from fes.arrays.edges import Edges
from fes.arrays.types import Floats, Ints
from tests.support.layouts import edges
from world.simulation import draw_cache
from world.simulation.draw_cache import DrawCache

KEY = draws.key(3, "channel")
IDS = range(6)
PAIRS = [(receiver, sender) for receiver in IDS for sender in IDS if receiver != sender]

some_pairs = st.lists(st.sampled_from(PAIRS), unique=True).map(sorted)


def direct(tick: int, pairs: Edges) -> Floats:
    """The numbers of a tick, drawn alone."""
    first = tick - tick % 4
    drawn: Floats = draws.uniform_ticks(KEY, first, 4, pairs.peers, pairs.robots)[tick - first]
    return drawn


def size(cache: DrawCache) -> int:
    """Numbers that a cache keeps."""
    return cache._block.size


def everyone(robots: int) -> Edges:
    """All pairs of so many robots."""
    ids = range(robots)
    return edges(ids, [(a, b) for a in ids for b in ids if a != b])


@settings(max_examples=200)
@given(steps=st.lists(st.tuples(st.integers(-3, 9), some_pairs), min_size=1, max_size=30), most=st.integers(1, 400))
def test_each_number_is_that_of_its_tick_and_pair_in_any_order_of_requests(
    steps: list[tuple[int, list[tuple[int, int]]]], most: int
) -> None:
    """While pairs come and go, ticks are skipped or asked again, and blocks are cut short by the bound."""
    cache, tick = DrawCache(KEY), 0
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(draw_cache, "_MOST", most)
        for later, pairs in steps:
            tick = max(0, tick + later)
            asked = edges(IDS, pairs)
            assert cache.numbers(tick, asked).tolist() == direct(tick, asked).tolist()
            assert size(cache) <= max(most, 4 * len(PAIRS))


def test_only_pairs_that_came_in_range_are_drawn_and_only_for_the_ticks_left(monkeypatch: pytest.MonkeyPatch) -> None:
    drawn: list[tuple[int, int, list[tuple[int, int]]]] = []
    original = draws.uniform_ticks

    def uniform_ticks(key: Ints, first: int, count: int, senders: Ints, receivers: Ints) -> Floats:
        drawn.append((first, count, list(zip(receivers.tolist(), senders.tolist(), strict=True))))
        return original(key, first, count, senders, receivers)

    monkeypatch.setattr(draws, "uniform_ticks", uniform_ticks)
    cache, two = DrawCache(KEY), edges(IDS, [(0, 1), (1, 0)])
    cache.numbers(0, two)
    cache.numbers(1, two)
    cache.numbers(50, edges(IDS, [(0, 1), (0, 2), (1, 0)]))
    cache.numbers(51, edges(IDS, [(0, 1)]))
    cache.numbers(128, two)
    assert drawn == [(0, 128, [(0, 1), (1, 0)]), (48, 80, [(0, 2)]), (128, 128, [(0, 1), (1, 0)])]


def test_a_pair_that_comes_takes_the_place_of_one_that_left() -> None:
    cache, before = DrawCache(KEY), edges(IDS, [(0, 1), (1, 0), (2, 3)])
    cache.numbers(0, before)
    kept = size(cache)
    for tick in range(1, 128):
        cache.numbers(tick, edges(IDS, [(0, 1), (1, 0), (2, 3 + tick % 3)]))
    assert size(cache) == kept


def test_room_for_pairs_doubles_so_that_few_blocks_are_copied() -> None:
    cache, sizes, pairs = DrawCache(KEY), set(), everyone(12)
    for tick in range(1, 128):
        few = pairs.select(np.arange(len(pairs)) < tick)
        assert cache.numbers(tick - 1, few).tolist() == direct(tick - 1, few).tolist()
        sizes.add(size(cache))
    assert sizes == {128 * columns for columns in (1, 2, 4, 8, 16, 32, 64, 128)}


def test_a_crowd_that_comes_in_range_shortens_the_block_to_the_bound(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(draw_cache, "_MOST", 4096)
    cache = DrawCache(KEY)
    cache.numbers(0, everyone(3))
    assert size(cache) == 128 * 6
    crowd = everyone(12)
    assert cache.numbers(5, crowd).tolist() == direct(5, crowd).tolist()
    assert size(cache) == 28 * 132  # the largest multiple of four ticks below 4096 numbers
