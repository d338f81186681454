"""Connectivity of an undirected graph given by its edges."""

import math

import numpy as np

from fes.arithmetic import sums
from fes.arrays.types import Bools, Floats, Ints

_TINY = 1e-300

MAX_DENSE = 1500
"""Largest number of robots whose algebraic connectivity is computed: the Laplacian is dense."""


def components(n: int, a: Ints, b: Ints) -> Ints:
    """Lowest row of each row's component [n], in a graph with the edges a-b [m].

    >>> components(4, np.array([0, 2]), np.array([1, 3])).tolist()
    [0, 0, 2, 2]
    """
    label = np.arange(n)
    while True:
        lowest = label.copy()
        np.minimum.at(lowest, a, label[b])
        np.minimum.at(lowest, b, label[a])
        lowest = lowest[lowest]  # jump: a row takes the label of its label
        if np.array_equal(lowest, label):
            return label
        label = lowest


def component_count(n: int, a: Ints, b: Ints) -> int:
    """Number of components of the graph."""
    return len(np.unique(components(n, a, b)))


def parts(present: Bools, a: Ints, b: Ints) -> int:
    """Number of components of the rows that are `present` [n], by the edges a-b [m] between these alone.

    >>> parts(np.array([True, True, False]), np.array([0, 1]), np.array([2, 2]))
    2
    """
    both = present[a] & present[b]
    return component_count(len(present), a[both], b[both]) - int(np.count_nonzero(~present))


def cut_rows(n: int, a: Ints, b: Ints) -> Ints:
    """Rows whose loss cuts their component in two or more, ascending; `n` rows with the edges a-b [m].

    They are the articulation points, by Hopcroft and Tarjan's search: a row cuts its component if the subtree of one
    of its children has no edge to an ancestor of the row. A root cuts it if it has two children or more.

    >>> cut_rows(4, np.array([0, 1, 2]), np.array([1, 2, 0])), cut_rows(3, np.array([0, 2]), np.array([1, 1]))
    (array([], dtype=int64), array([1]))
    """
    neighbors: list[list[int]] = [[] for _ in range(n)]
    for first, second in zip(a.tolist(), b.tolist(), strict=True):
        neighbors[first].append(second)
        neighbors[second].append(first)
    order, earliest, cuts = [-1] * n, [0] * n, set[int]()
    for root in range(n):
        if order[root] >= 0:
            continue
        begun = 0  # rows of the tree so far, of this root only
        order[root] = earliest[root] = begun
        path = [(root, iter(neighbors[root]))]
        branches = 0
        while path:
            row, rest = path[-1]
            child = next(rest, None)
            if child is None:
                path.pop()
                if not path:
                    continue
                parent = path[-1][0]
                earliest[parent] = min(earliest[parent], earliest[row])
                branches += parent == root
                if parent != root and earliest[row] >= order[parent]:
                    cuts.add(parent)
            elif order[child] < 0:
                begun += 1
                order[child] = earliest[child] = begun
                path.append((child, iter(neighbors[child])))
            else:
                earliest[row] = min(earliest[row], order[child])
        if branches > 1:
            cuts.add(root)
    return np.array(sorted(cuts), dtype=np.int64)


def laplacian(n: int, a: Ints, b: Ints) -> Floats:
    """Laplacian L = D - A [n, n] of the unweighted graph."""
    result = np.zeros((n, n))
    result[a, b] = result[b, a] = -1.0
    result[np.diag_indices(n)] = -np.add.reduce(result, axis=0)
    return result


def algebraic_connectivity(n: int, a: Ints, b: Ints) -> float | None:
    """lambda_2 of the Laplacian: positive iff the graph is connected; None for more than MAX_DENSE robots."""
    if n < 2:
        return 0.0
    if n > MAX_DENSE:
        return None
    if component_count(n, a, b) > 1:
        return 0.0
    return max(0.0, _second_smallest(*_tridiagonal(laplacian(n, a, b))))


def _tridiagonal(matrix: Floats) -> tuple[Floats, Floats]:
    """Diagonal [n] and off-diagonal [n - 1] of a tridiagonal matrix with the eigenvalues of a symmetric one [n, n].

    By Householder's reflections, with all sums term by term: LAPACK's digits depend on the processor.
    """
    rest, n = matrix, len(matrix)
    diagonal, beside = np.zeros(n), np.zeros(n - 1)
    for row in range(n - 2):
        diagonal[row], column, rest = rest[0, 0], rest[1:, 0], rest[1:, 1:]
        size = math.sqrt(sums.total(column * column))
        if size == 0.0:
            continue
        beside[row] = -math.copysign(size, column[0])
        normal = column.copy()
        normal[0] -= beside[row]
        scale = 2.0 / sums.total(normal * normal)
        product = scale * sums.of_columns(rest * normal[:, None])  # the matrix is symmetric
        product -= (0.5 * scale * sums.total(normal * product)) * normal
        rest = rest - normal[:, None] * product - product[:, None] * normal
    diagonal[n - 2 :] = rest[0, 0], rest[1, 1]
    beside[n - 2] = rest[1, 0]
    return diagonal, beside


def _second_smallest(diagonal: Floats, beside: Floats) -> float:
    """The second smallest eigenvalue of a tridiagonal matrix, by bisection with Sturm's sequence."""
    squares = [0.0, *(beside * beside).tolist()]
    entries = list(zip(diagonal.tolist(), squares, strict=True))
    low, high = 0.0, 2.0 * float(np.abs(diagonal).max()) + 1.0
    while True:
        middle = 0.5 * (low + high)
        if not low < middle < high:
            return high
        below, pivot = 0, 1.0
        for entry, square in entries:
            pivot = entry - middle - square / pivot
            if pivot == 0.0:
                pivot = -_TINY
            below += pivot < 0.0
        low, high = (low, middle) if below >= 2 else (middle, high)
