"""Components and algebraic connectivity against scipy's search and closed forms."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fes.arrays.types import Ints
from tests.support import reference as witness
from world.metrics import graphs

Pairs = list[tuple[int, int]]


def ends(pairs: Pairs) -> tuple[Ints, Ints]:
    a, b = np.array(pairs, dtype=np.int64).reshape(-1, 2).T
    return a, b


@st.composite
def random_graphs(draw: st.DrawFn) -> tuple[int, Pairs]:
    n = draw(st.integers(2, 14))
    every = [(i, j) for i in range(n) for j in range(i + 1, n)]
    return n, draw(st.lists(st.sampled_from(every), unique=True, max_size=20))


@given(graph=random_graphs())
def test_components_are_those_of_scipys_search(graph: tuple[int, Pairs]) -> None:
    n, pairs = graph
    labels = witness.component_labels(n, pairs)
    lowest = [labels.index(label) for label in labels]  # the first of each component
    assert graphs.components(n, *ends(pairs)).tolist() == lowest
    assert graphs.component_count(n, *ends(pairs)) == len(set(labels))


@given(graph=random_graphs())
def test_algebraic_connectivity_is_the_second_eigenvalue_of_the_laplacian(graph: tuple[int, Pairs]) -> None:
    n, pairs = graph
    incidence = np.zeros((n, len(pairs)))  # L = B B', not built as D - A
    for k, (i, j) in enumerate(pairs):
        incidence[i, k], incidence[j, k] = 1.0, -1.0
    singular = np.zeros(n)
    values = np.linalg.svd(incidence, compute_uv=False)
    singular[: len(values)] = values[:n]
    expected = sorted(singular**2)[1]
    result = graphs.algebraic_connectivity(n, *ends(pairs))
    assert result == pytest.approx(expected, abs=1e-12)  # roundings of eigenvalues <= 14
    connected = len(set(witness.component_labels(n, pairs))) == 1
    # a connected graph has lambda_2 >= 4/(n diameter) >= 4/14^2
    assert (result is not None and result > 0.01) == connected


@pytest.mark.parametrize("n", [3, 10, 64])
def test_paths_rings_and_cliques_have_the_connectivity_of_the_textbook(n: int) -> None:
    path = [(k, k + 1) for k in range(n - 1)]
    clique = [(i, j) for i in range(n) for j in range(i)]
    cases = [
        (path, 2.0 * (1.0 - math.cos(math.pi / n))),
        ([*path, (n - 1, 0)], 2.0 * (1.0 - math.cos(2.0 * math.pi / n))),
        (clique, float(n)),
    ]
    for pairs, expected in cases:
        assert graphs.algebraic_connectivity(n, *ends(pairs)) == pytest.approx(expected, abs=1e-12)


def test_an_edge_given_in_both_directions_is_one_edge() -> None:
    assert graphs.laplacian(3, *ends([(0, 1), (1, 0), (1, 2)])).tolist() == [
        [1, -1, 0],
        [-1, 2, -1],
        [0, -1, 1],
    ]


def test_a_long_path_in_random_order_is_one_component() -> None:
    order = np.random.default_rng(0).permutation(3000)
    assert graphs.component_count(3000, order[:-1], order[1:]) == 1
    assert graphs.component_count(3000, order[:1500], order[1:1501]) == 1500


def test_a_lone_robot_and_a_crowd_have_no_algebraic_connectivity() -> None:
    nothing = ends([])
    assert graphs.algebraic_connectivity(1, *nothing) == 0.0
    assert graphs.algebraic_connectivity(graphs.MAX_DENSE + 1, *nothing) is None
