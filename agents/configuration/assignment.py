"""Assignment of rows to columns with the least sum of costs, by shortest augmenting paths.

After Jonker and Volgenant, "A shortest augmenting path algorithm for dense and sparse linear assignment problems"
(1987), without their initialization by column reduction. O(n^3).
"""

import numpy as np

from fes.arithmetic import sums
from fes.arrays.types import Floats, Ints

FREE = -1
"""Stands for a row or a column that is not assigned yet."""


def least_sum(costs: Floats) -> Ints:
    """The column of each row [n] that gives the least sum of `costs` [n, n], all finite.

    Every step is one comparison or one + or - of doubles. So equal costs give equal results on every processor, also
    where several assignments are equally good.
    """
    n = len(costs)
    row_price, column_price = np.minimum.reduce(costs, axis=1), np.zeros(n)
    row_of, column_of = _cheapest(costs)
    for start in np.flatnonzero(column_of == FREE).tolist():
        length, before, is_done, last = _shortest_path(costs, row_price, column_price, row_of, start)
        least = length[last]
        rows = row_of[is_done & (row_of != FREE)]
        row_price[rows] += least - length[column_of[rows]]
        row_price[start] += least
        column_price[is_done] += length[is_done] - least
        _augment(row_of, column_of, before, start, last)
    return column_of


def at_least(costs: Floats) -> float:
    """A lower bound of the least sum of `costs` [n, n]: each row, or each column, has its cheapest entry."""
    return max(sums.total(np.minimum.reduce(costs, axis=1)), sums.total(np.minimum.reduce(costs, axis=0)))


def _cheapest(costs: Floats) -> tuple[Ints, Ints]:
    """Row of each column [n] and column of each row [n]: a row gets its cheapest column, if no earlier row has it."""
    n = len(costs)
    row_of, column_of = np.full(n, FREE), np.full(n, FREE)
    for row, column in enumerate(costs.argmin(axis=1).tolist()):
        if row_of[column] == FREE:
            row_of[column], column_of[row] = row, column
    return row_of, column_of


def _shortest_path(
    costs: Floats, row_price: Floats, column_price: Floats, row_of: Ints, start: int
) -> tuple[Floats, Ints, np.ndarray, int]:
    """The shortest path of reduced costs from row `start` to a free column, which is the last result.

    The others are the length of the path to each column [n], the row before it [n], and True for a column whose
    length is final [n].
    """
    n = len(costs)
    length, before, is_done = np.full(n, np.inf), np.full(n, FREE), np.zeros(n, dtype=np.bool_)
    row, least = start, 0.0
    while True:
        through = costs[row] - column_price + (least - row_price[row])
        is_shorter = (through < length) & ~is_done
        length = np.where(is_shorter, through, length)
        before[is_shorter] = row
        column = int(np.where(is_done, np.inf, length).argmin())
        least, is_done[column] = length[column], True
        if row_of[column] == FREE:
            return length, before, is_done, column
        row = row_of[column]


def _augment(row_of: Ints, column_of: Ints, before: Ints, start: int, column: int) -> None:
    """Assign, in place, the columns along the path that ends at `column`, each to the row before it."""
    while True:
        row = int(before[column])
        row_of[column] = row
        column_of[row], column = column, int(column_of[row])
        if row == start:
            return
