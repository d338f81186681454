"""Counter-based draws: which numbers, and that nothing but their five coordinates matters."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fes.arithmetic import draws
from fes.arrays.types import Floats, Ints
from tests.support import reference as witness

KEY = draws.key(7, "channel")

pair_lists = st.lists(st.tuples(st.integers(0, 99_999), st.integers(0, 99_999)), min_size=1, max_size=8, unique=True)


def numbers(pairs: list[tuple[int, int]], first: int, count: int, key: Ints = KEY) -> Floats:
    senders, receivers = np.array(pairs, dtype=np.int64).reshape(-1, 2).T
    return draws.uniform_ticks(key, first, count, senders, receivers)


@given(pairs=pair_lists, blocks=st.lists(st.sampled_from([4, 8, 16, 64]), min_size=1, max_size=6))
def test_the_numbers_do_not_depend_on_how_ticks_are_cut_into_blocks(
    pairs: list[tuple[int, int]], blocks: list[int]
) -> None:
    together = numbers(pairs, 0, sum(blocks))
    firsts = [sum(blocks[:k]) for k in range(len(blocks))]
    parts = [numbers(pairs, first, count) for first, count in zip(firsts, blocks, strict=True)]
    assert np.concatenate(parts).tolist() == together.tolist()
    assert len(set(together.ravel().tolist())) == together.size  # and they are different numbers


@given(pairs=pair_lists, data=st.data())
def test_draws_depend_neither_on_other_requested_links_nor_on_their_order(
    pairs: list[tuple[int, int]], data: st.DataObject
) -> None:
    shuffled = data.draw(st.permutations(pairs))
    ordered, reordered = numbers(pairs, 8, 8), numbers(shuffled, 8, 8)
    single = numbers(pairs[:1], 8, 8)
    for column, pair in enumerate(pairs):
        assert ordered[:, column].tolist() == reordered[:, shuffled.index(pair)].tolist()
    assert ordered[:, 0].tolist() == single[:, 0].tolist()


def test_a_number_is_that_of_numpy_at_the_counter_of_its_coordinates() -> None:
    result = numbers([(5, 9), (9, 5)], 12, 8)
    for column, (sender, receiver) in enumerate([(5, 9), (9, 5)]):
        # counter (tick / 4, sender, receiver): Philox counts up before its first block of four words
        counter = np.array([12 // 4, sender, receiver, 0], dtype=np.uint64)
        generator = np.random.Generator(np.random.Philox(key=KEY, counter=counter))
        assert result[:, column].tolist() == generator.random(8).tolist()


def test_a_pair_and_its_reverse_have_different_numbers() -> None:
    result = numbers([(5, 9), (9, 5)], 0, 64)
    assert not set(result[:, 0].tolist()) & set(result[:, 1].tolist())


def test_numbers_are_uniform_along_ticks_and_across_pairs() -> None:
    along = numbers([(3, 4)], 0, 20_000)[:, 0]
    across = draws.uniform_pairs(KEY, np.arange(20_000), np.full(20_000, 7))
    for sample in (along, across):
        assert sample.min() >= 0.0
        assert sample.max() < 1.0
        assert witness.uniform_p_value(sample) > 1e-3  # a fixed sample: fails for one seed in a thousand
        neighbors = np.corrcoef(sample[:-1], sample[1:])[0, 1]
        assert abs(neighbors) < 4.0 / math.sqrt(len(sample))  # 4 sigma of independent numbers


@pytest.mark.parametrize("other", [draws.key(7, "first estimate"), draws.key(8, "channel")])
def test_another_stream_or_seed_gives_unrelated_numbers(other: Ints) -> None:
    first, second = numbers([(0, 1)], 0, 20_000)[:, 0], numbers([(0, 1)], 0, 20_000, other)[:, 0]
    assert not set(first.tolist()) & set(second.tolist())
    assert abs(np.corrcoef(first, second)[0, 1]) < 4.0 / math.sqrt(20_000)  # 4 sigma


def test_the_same_seed_and_stream_give_the_same_key() -> None:
    assert draws.key(7, "channel").tolist() == KEY.tolist()


@pytest.mark.parametrize(("first", "count"), [(2, 4), (4, 6), (1, 1)])
def test_ticks_come_in_blocks_of_four(first: int, count: int) -> None:
    with pytest.raises(ValueError, match="blocks of 4"):
        numbers([(0, 1)], first, count)


def test_a_request_for_no_pairs_gives_no_numbers() -> None:
    assert numbers([], 0, 8).shape == (8, 0)


def test_sub_seeds_are_seeds_of_their_own() -> None:
    result = [draws.sub_seed(seed, stream) for seed in range(500) for stream in ("agents", "world")]
    assert len(set(result)) == 1000
    assert all(type(seed) is int and 0 <= seed < 2**53 for seed in result)
    assert witness.uniform_p_value(np.array(result) / 2.0**53) > 1e-3  # nothing of the seed shows
    assert draws.sub_seed(3, "agents") == draws.sub_seed(3, "agents")
