"""Connectivity of an undirected graph given by its edges."""

import numpy as np

from fes.arrays.types import Floats, Ints

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


def laplacian(n: int, a: Ints, b: Ints) -> Floats:
    """Laplacian L = D - A [n, n] of the unweighted graph."""
    result = np.zeros((n, n))
    result[a, b] = result[b, a] = -1.0
    result[np.diag_indices(n)] = -result.sum(axis=1)
    return result


def algebraic_connectivity(n: int, a: Ints, b: Ints) -> float | None:
    """lambda_2 of the Laplacian: positive iff the graph is connected; None for more than MAX_DENSE robots."""
    if n < 2:
        return 0.0
    if n > MAX_DENSE:
        return None
    return max(0.0, float(np.linalg.eigvalsh(laplacian(n, a, b))[1]))
