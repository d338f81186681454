"""The marks that each robot knows: of its present period, and of the next one if a peer's clock is ahead.

A mark (e, i, x, y, estimate) is what robot i declares once for period e. The first one that a robot learns stays.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fes.arrays.types import Bools, Floats, Ints

Marks = NDArray[np.float32]
"""x, y [m; world frame] and estimate [m] [..., 3], as they travel."""

NOW, NEXT = 0, 1
"""Periods in a table, relative to that of its robot's clock."""

REMEMBERED = 30
"""Periods for which the last mark of each id is remembered."""

NEVER = -(2**40)
"""Period of the last mark of an id that was never heard."""

MANY = 256
"""A table of more ids than this drops those that no robot remembers, before it grows."""


@dataclass(frozen=True, eq=False)
class Table:
    """The marks that n robots know of N ids. An id has a column as soon as any robot of the crew heard it."""

    ids: Ints
    """Ids within the run, ascending [N]."""
    is_known: Bools
    """True for a mark that a robot knows, of the period NOW or NEXT [2, n, N]."""
    marks: Marks
    """[2, n, N, 3]"""
    last_epoch: Ints
    """Period of the last mark that each robot accepted of each id [n, N]."""
    last_place: Marks
    """x, y of that mark [n, N, 2]."""

    def counts(self, own: Ints) -> Ints:
        """Number of ids of the present period that each robot knows, with its `own` [n] [n]."""
        is_known = self.is_known[NOW]
        rows = np.arange(len(own))
        result: Ints = np.count_nonzero(is_known, axis=1) + ~is_known[rows, self.columns(own)]
        return result

    def columns(self, ids: Ints) -> Ints:
        """Columns of `ids` that are in the table; any shape."""
        columns: Ints = np.searchsorted(self.ids, ids)
        return columns

    def known(self, row: int) -> tuple[Ints, Marks]:
        """Ids and marks of the present period that a robot knows [k], [k, 3]."""
        is_known = self.is_known[NOW, row]
        return self.ids[is_known], self.marks[NOW, row, is_known]


def empty(n: int, ids: Ints) -> Table:
    """The table of `n` robots that know no mark, for the ids of the crew."""
    ids = np.unique(ids)
    size = n, len(ids)
    return Table(
        ids,
        np.zeros((2, *size), dtype=np.bool_),
        np.zeros((2, *size, 3), dtype=np.float32),
        np.full(size, NEVER),
        np.zeros((*size, 2), dtype=np.float32),
    )


def forget(table: Table, restarted: Bools) -> Table:
    """The table without the marks that the robots `restarted` [n] knew."""
    return replace(
        table,
        is_known=table.is_known & ~restarted[:, None],
        last_epoch=np.where(restarted[:, None], NEVER, table.last_epoch),
    )


def advance(table: Table, periods: Ints) -> Table:
    """The table when each robot's clock is this many `periods` further [n]; marks of other periods are gone."""
    is_known, marks = np.zeros_like(table.is_known), table.marks.copy()
    is_same, is_next = periods == 0, periods == 1
    is_known[:, is_same] = table.is_known[:, is_same]
    is_known[NOW, is_next] = table.is_known[NEXT, is_next]
    marks[NOW, is_next] = table.marks[NEXT, is_next]
    return replace(table, is_known=is_known, marks=marks)


def with_own(table: Table, rows: Ints, ids: Ints, marks: Floats) -> Table:
    """The table with the own marks [m, 3] of the robots `rows`, whose ids are `ids` [m], in the present period."""
    is_known, values = table.is_known.copy(), table.marks.copy()
    columns = table.columns(ids)
    is_known[NOW, rows, columns] = True
    values[NOW, rows, columns] = marks
    return replace(table, is_known=is_known, marks=values)


def with_heard(table: Table, period: Ints, rows: Ints, ids: Ints, epochs: Ints, marks: Marks) -> Table:
    """The table with marks that the robots `rows` heard: of NOW or NEXT (`period`), the period `epochs` [m]."""
    is_known, values = table.is_known.copy(), table.marks.copy()
    last_epoch, last_place = table.last_epoch.copy(), table.last_place.copy()
    columns = table.columns(ids)
    is_known[period, rows, columns] = True
    values[period, rows, columns] = marks
    for which in (NOW, NEXT):  # the later one is the last
        is_last = (period == which) & (epochs > last_epoch[rows, columns])
        last_epoch[rows[is_last], columns[is_last]] = epochs[is_last]
        last_place[rows[is_last], columns[is_last]] = marks[is_last, :2]
    return Table(table.ids, is_known, values, last_epoch, last_place)


def grown(table: Table, ids: Ints, own: Ints, oldest: int) -> Table:
    """The table with columns for `ids` too. A large one drops ids of which no mark is of period `oldest` or later.

    It keeps the `own` ids of its robots [n].
    """
    if len(table.ids) > MANY:
        is_remembered = table.last_epoch >= oldest
        is_kept: Bools = np.logical_or.reduce(is_remembered | table.is_known[NOW] | table.is_known[NEXT], axis=0)
        table = _selected(table, is_kept | np.isin(table.ids, own))
    wanted = np.unique(np.concatenate([table.ids, ids]))
    if len(wanted) == len(table.ids):
        return table
    larger, columns = empty(table.is_known.shape[1], wanted), np.searchsorted(wanted, table.ids)
    larger.is_known[:, :, columns] = table.is_known
    larger.marks[:, :, columns] = table.marks
    larger.last_epoch[:, columns] = table.last_epoch
    larger.last_place[:, columns] = table.last_place
    return larger


def _selected(table: Table, is_kept: Bools) -> Table:
    """The table with the columns where `is_kept` [N]."""
    return Table(
        table.ids[is_kept],
        table.is_known[:, :, is_kept],
        table.marks[:, :, is_kept],
        table.last_epoch[:, is_kept],
        table.last_place[:, is_kept],
    )
