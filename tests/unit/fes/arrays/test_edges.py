"""Sums and look-ups over directed pairs, against loops over Python lists."""

from functools import reduce
from operator import add

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fes.arrays.edges import Edges, Stack, no_edges
from tests.support.layouts import edges

Pairs = list[tuple[int, int]]

pair_sets = st.sets(
    st.tuples(st.integers(0, 12), st.integers(0, 12)).filter(lambda pair: pair[0] != pair[1]), max_size=60
)
CREW = range(13)
RNG = np.random.default_rng(8)
WILD = dict(zip([(i, j) for i in CREW for j in CREW], RNG.normal(0, 10.0 ** RNG.integers(-8, 8, 169)), strict=True))
"""Numbers of very different size: their sum depends on its order."""


def values(among: Edges) -> list[float]:
    robots = among.ids[among.rows].tolist()
    return [float(WILD[pair]) for pair in zip(robots, among.peers.tolist(), strict=True)]


@given(pairs=pair_sets)
def test_a_sum_adds_a_robots_pairs_one_by_one_in_the_order_of_their_peers(
    pairs: set[tuple[int, int]],
) -> None:
    among = edges(CREW, pairs)
    expected = []
    for robot in CREW:
        total = 0.0
        for peer in sorted(peer for i, peer in pairs if i == robot):
            total += float(WILD[robot, peer])
        expected.append(total)
    assert among.sum(np.array(values(among))).tolist() == expected  # to the bit


def test_a_long_sum_is_added_one_by_one_too() -> None:
    # numpy's own sum adds in eight lanes, and in pairs beyond 128
    rng = np.random.default_rng(3)
    among = edges([0, 1], [(0, peer) for peer in range(1, 301)] + [(1, peer) for peer in range(2, 40)])
    numbers = rng.normal(0.0, 10.0 ** rng.integers(-8, 8, len(among)))
    expected = [0.0, 0.0]
    for row, number in zip(among.rows.tolist(), numbers.tolist(), strict=True):
        expected[row] += number
    assert among.sum(numbers).tolist() == expected  # to the bit
    assert float(np.sum(numbers[:300])) != expected[0]  # so that the order shows


def test_the_order_of_a_sum_matters_to_its_digits() -> None:
    # or the test above would show nothing; not by sum(), which makes up for rounding from Python 3.12 on
    row = [float(WILD[3, peer]) for peer in CREW]
    assert len({reduce(add, np.random.default_rng(k).permutation(row).tolist()) for k in range(20)}) > 1


@given(pairs=pair_sets, crew=st.sets(st.sampled_from(list(CREW)), min_size=1))
def test_a_robots_sum_does_not_depend_on_other_robots_of_its_process(
    pairs: set[tuple[int, int]], crew: set[int]
) -> None:
    together = edges(CREW, pairs)
    part = edges(crew, {pair for pair in pairs if pair[0] in crew})
    metrics = together.sum(np.array(values(together)))
    assert part.sum(np.array(values(part))).tolist() == metrics[sorted(crew)].tolist()  # to the bit


@given(pairs=pair_sets, wanted=pair_sets)
def test_find_gives_the_position_of_a_pair_or_minus_one(
    pairs: set[tuple[int, int]], wanted: set[tuple[int, int]]
) -> None:
    ordered = sorted(pairs)
    result = edges(CREW, pairs).find(edges(CREW, wanted).keys).tolist()
    assert result == [ordered.index(pair) if pair in pairs else -1 for pair in sorted(wanted)]


@given(pairs=pair_sets)
def test_reverse_mutual_undirected_and_counts_equal_those_of_a_list(pairs: set[tuple[int, int]]) -> None:
    among, ordered = edges(CREW, pairs), sorted(pairs)
    back = [(j, i) in pairs for i, j in ordered]
    assert among.reverse.tolist() == [
        ordered.index((j, i)) if there else -1 for (i, j), there in zip(ordered, back, strict=True)
    ]
    assert among.mutual.tolist() == [k for k, (i, j) in enumerate(ordered) if back[k] and i < j]
    assert among.undirected.tolist() == [k for k, (i, j) in enumerate(ordered) if not back[k] or i < j]
    assert among.counts.tolist() == [sum(i == robot for i, _ in ordered) for robot in CREW]


@given(pairs=pair_sets, levels=st.lists(st.integers(0, 2), min_size=169, max_size=169), k=st.integers(1, 3))
def test_smallest_finds_the_k_smallest_of_each_robot_and_among_equals_the_lowest_peers(
    pairs: set[tuple[int, int]], levels: list[int], k: int
) -> None:
    among, ordered = edges(CREW, pairs), sorted(pairs)
    level = {pair: float(levels[13 * pair[0] + pair[1]]) for pair in ordered}
    expected: set[tuple[int, int]] = set()
    for robot in CREW:
        mine = [pair for pair in ordered if pair[0] == robot]
        expected |= set(sorted(mine, key=lambda pair: (level[pair], pair[1]))[:k])
    result = among.smallest(np.array([level[pair] for pair in ordered]), k)
    assert {ordered[position] for position in result.tolist()} == expected
    if k == 1:
        values = np.array([level[pair] for pair in ordered])
        assert {ordered[position] for position in among.first_smallest(values).tolist()} == expected


def test_smallest_finds_one_of_values_that_are_all_infinite() -> None:
    among = edges([0, 1], [(0, 1), (0, 2), (1, 0)])
    assert among.smallest(np.full(3, np.inf), 1).tolist() == [0, 2]
    assert among.first_smallest(np.full(3, np.inf)).tolist() == [0, 2]


def test_ties_are_broken_beside_a_robot_whose_values_are_nan() -> None:
    # The digits of a robot must not depend on those of another one in its process.
    among = edges([0, 1], [(0, 1), (1, 0), (1, 2)])
    assert among.first_smallest(np.array([np.nan, 3.0, 3.0])).tolist() == [1]


@given(pairs=pair_sets)
def test_select_keeps_the_marked_pairs(pairs: set[tuple[int, int]]) -> None:
    ordered = sorted(pairs)
    mask = np.array([(i + j) % 2 == 0 for i, j in ordered], dtype=np.bool_)
    kept = edges(CREW, pairs).select(mask)
    expected = [pair for pair in ordered if sum(pair) % 2 == 0]
    assert list(zip(kept.ids[kept.rows].tolist(), kept.peers.tolist(), strict=True)) == expected


def test_a_crew_without_pairs_sums_to_zero_and_finds_nothing() -> None:
    empty = no_edges(np.array([4, 7]))
    assert empty.sum(np.zeros(0)).tolist() == [0.0, 0.0]
    assert empty.find(np.array([5, 6])).tolist() == [-1, -1]
    assert empty.smallest(np.zeros(0), 1).tolist() == empty.first_smallest(np.zeros(0)).tolist() == []


TYPES = st.sampled_from((np.float64, np.int64, np.uint8, np.bool_))


@given(before=pair_sets, now=pair_sets, kind=TYPES, fill=st.sampled_from([0, 1]))
def test_carried_values_stay_with_their_pairs_and_new_pairs_get_the_fill(
    before: set[tuple[int, int]], now: set[tuple[int, int]], kind: type[np.generic], fill: int
) -> None:
    old, new = edges(CREW, before), edges(CREW, now)
    numbers = (np.arange(len(old)) % 3).astype(kind)
    position = {pair: k for k, pair in enumerate(sorted(before))}
    expected = [numbers[position[pair]].item() if pair in before else kind(fill) for pair in sorted(now)]
    carried = new.carry(numbers, old, fill)
    assert carried.tolist() == expected
    assert carried.dtype == numbers.dtype


@given(before=pair_sets, now=pair_sets, axis=st.integers(0, 2))
def test_an_array_with_several_axes_is_carried_along_the_axis_of_the_pairs(
    before: set[tuple[int, int]], now: set[tuple[int, int]], axis: int
) -> None:
    old, new = edges(CREW, before), edges(CREW, now)
    shape = [2, 3]
    shape.insert(axis, len(old))
    numbers = np.arange(6.0 * len(old)).reshape(shape)
    position = {pair: k for k, pair in enumerate(sorted(before))}
    columns = [
        numbers.take(position[pair], axis) if pair in before else np.full((2, 3), -1.0) for pair in sorted(now)
    ]
    expected = np.stack(columns, axis) if columns else np.zeros([n if k != axis else 0 for k, n in enumerate(shape)])
    carried = new.carry(numbers, old, -1.0, axis)
    assert carried.shape == expected.shape
    assert carried.tolist() == expected.tolist()


@given(before=pair_sets, now=pair_sets)
def test_a_transition_tells_new_pairs_from_old_ones_and_changes_no_input(
    before: set[tuple[int, int]], now: set[tuple[int, int]]
) -> None:
    old, new = edges(CREW, before), edges(CREW, now)
    transition, numbers = new.after(old), np.arange(len(old))
    assert transition.is_new.tolist() == [pair not in before for pair in sorted(now)]
    transition.carry(numbers, -1)[:] = 7
    assert numbers.tolist() == list(range(len(old)))


def test_the_same_edges_keep_their_values_as_they_are() -> None:
    among, numbers = edges([0, 1], [(0, 1), (1, 0)]), np.array([3.0, 4.0])
    assert among.carry(numbers, among, 0.0) is numbers
    assert among.after(among).carry(numbers, 0.0).tolist() == [3.0, 4.0]


def test_a_fill_that_the_type_of_the_values_cannot_hold_is_an_error() -> None:
    old, new = edges([0], [(0, 1)]), edges([0], [(0, 2)])
    with pytest.raises(ValueError, match="NaN"):
        new.carry(np.array([1]), old, np.nan)


@pytest.mark.parametrize("largest", [99_999])
def test_the_keys_of_pairs_in_the_largest_team_do_not_collide(largest: int) -> None:
    among = edges([0, 1, largest], [(0, 1), (0, largest), (1, 0), (largest, 0), (largest, 1)])
    assert among.reverse.tolist() == [2, 3, 0, 1, -1]


def test_a_stack_returns_the_same_edges_until_one_of_its_lists_is_replaced() -> None:
    stack, ids = Stack(), np.array([3, 5])
    lists = [np.array([1, 5]), np.array([3])]
    first = stack.edges(ids, lists)
    assert sorted(zip(first.ids[first.rows].tolist(), first.peers.tolist(), strict=True)) == [
        (3, 1),
        (3, 5),
        (5, 3),
    ]
    assert stack.edges(ids, list(lists)) is first
    second = stack.edges(ids, [lists[0], np.array([1, 3])])
    assert second.peers.tolist() == [1, 5, 1, 3]
    assert [first.peers[span].tolist() for span in first.spans] == [[1, 5], [3]]
