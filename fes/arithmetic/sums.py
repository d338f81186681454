"""Sums in the order of their terms. numpy adds long arrays in an order that depends on its version."""

import numpy as np

from fes.arrays.types import Floats


def total(values: Floats) -> float:
    """The sum of all values [m], term by term; 0 without any.

    >>> total(np.array([0.1, 0.2, 0.3]))
    0.6000000000000001
    """
    return float(np.add.accumulate(values)[-1]) if len(values) else 0.0


def mean(values: Floats) -> float:
    """The mean of values [m]; NaN without any."""
    return total(values) / len(values) if len(values) else float("nan")


def of_columns(values: Floats) -> Floats:
    """The sum of each column of values [n, m], term by term [m]."""
    if values.shape[1] == 1:  # numpy would add a single column in pairs
        return np.array([total(values[:, 0])])
    result: Floats = np.add.reduce(np.ascontiguousarray(values), axis=0)
    return result


def of_rows(values: Floats) -> Floats:
    """The sum of each row of values [n, m], term by term [n]."""
    return of_columns(values.T)


def product(first: Floats, second: Floats) -> Floats:
    """The matrix product of [..., i, k] and [..., k, j], k >= 1, its terms added in the order of k."""
    result = first[..., :, 0, None] * second[..., None, 0, :]
    for k in range(1, first.shape[-1]):
        result = result + first[..., :, k, None] * second[..., None, k, :]
    return result
