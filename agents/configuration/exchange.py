"""Marks in beacons: the bytes that a robot sends, and which of the marks that it hears it accepts.

A beacon has the sender's period, its own mark, and up to m marks of other robots of the same period, round-robin. So
all marks reach all robots of a connected team in about n / m ticks and two for each hop of the longest route.

The first place of a beacon is its sender's: another robot's mark there is refused. A relayed mark is not signed: a
dishonest peer may relay another mark than it heard. Four rules bound what that does. The first mark of a robot in a
period stays. A mark that is further from the last one than a robot can have moved is refused. No robot takes its own
mark from the air if it has one. A robot knows at most MOST marks.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from agents.configuration import table as tables
from agents.configuration.table import NEXT, NOW, REMEMBERED, Marks, Table
from fes.arrays import geometry
from fes.arrays.types import Bools, Bytes, Ints
from fes.extension.neighborhood import Neighborhood

EMPTY = 65535
"""The id of a place without a mark. Ids of robots are lower."""

MOST = 200
"""Largest number of marks of one period that a robot knows."""

FARTHEST = 1e9
"""Largest magnitude of a coordinate or an estimate in a mark [m]."""

ROUNDING = 1.0
"""Allowance for the rounding of positions [m]."""

_WRAP = 2**32  # a beacon has the last 32 bits of the period's number


class Heard(NamedTuple):
    """Marks that a crew hears at one tick [h], by peer in ascending order, each peer's in the order of its beacon."""

    rows: Ints
    """Row of the robot that heard the mark [h]."""
    period: Ints
    """Period of the mark relative to that of its hearer's clock: NOW or NEXT [h]."""
    ids: Ints
    """Id of the robot that made the mark [h]."""
    marks: Marks
    """x, y and estimate [h, 3] [m]."""

    def where(self, is_kept: Bools) -> "Heard":
        """The marks where `is_kept` [h]."""
        return Heard(self.rows[is_kept], self.period[is_kept], self.ids[is_kept], self.marks[is_kept])


class Exchange:
    """The exchange of marks of a crew."""

    def __init__(
        self, ids: Ints, own_ids: Callable[[Ints], Ints], relayed: int, most: int, farthest: float | None
    ) -> None:
        """`ids` are those of the crew [n], and `own_ids` gives ids within the run; `relayed` is m.

        `farthest` [m] bounds the path of a robot in a period.
        """
        mark = [("id", "<u2"), ("mark", "<f4", (3,))]
        self._layout = np.dtype([("epoch", "<u4"), ("marks", mark, (1 + relayed,))])
        self._own, self._own_ids = own_ids(ids), own_ids
        self._relayed, self._most, self._farthest = relayed, most, farthest
        self._lookup = (np.zeros(0, dtype=np.int64),) * 2
        self.size = self._layout.itemsize
        """Bytes in each beacon."""

    def send(self, table: Table, epoch: Ints, last: Ints) -> tuple[Bytes, Ints]:
        """The bytes of the robots' beacons [n, b], and the last id that each robot relayed [n].

        `last` [n] are those of the previous tick.
        """
        n, columns = len(self._own), len(table.ids)
        rows, own = np.arange(n), table.columns(self._own)
        is_known = table.is_known[NOW]
        # its own mark is first; then the others, round-robin, from the id that follows the last one
        first = np.searchsorted(table.ids, last, side="right")
        turn = np.where(is_known, (np.arange(columns) - first[:, None]) % columns, columns)
        turn[rows, own] = -1
        chosen = turn.argsort(axis=1, kind="stable")[:, : 1 + self._relayed]
        is_sent = turn[rows[:, None], chosen] < columns
        is_sent[:, 0] = is_known[rows, own]

        message = np.zeros(n, dtype=self._layout)
        message["epoch"] = epoch % _WRAP
        ids, marks = message["marks"]["id"], message["marks"]["mark"]
        ids[:, chosen.shape[1] :] = EMPTY
        ids[:, : chosen.shape[1]] = np.where(is_sent, table.ids[chosen], EMPTY)
        marks[:, : chosen.shape[1]] = np.where(is_sent[:, :, None], table.marks[NOW, rows[:, None], chosen], 0.0)
        count = np.count_nonzero(is_sent[:, 1:], axis=1)
        last = np.where(count > 0, table.ids[chosen[rows, count]], last)
        return message.view(np.uint8).reshape(n, -1), last

    def hear(self, table: Table, epoch: Ints, around: Neighborhood) -> Table:
        """The table with the marks accepted from the beacons of the previous tick; `epoch` [n] is each robot's."""
        heard = self._unknown(table, epoch, around)
        if not len(heard.rows):
            return table
        # its own mark of the next period can only be forged: it has not made it yet
        is_own = heard.ids == self._own[heard.rows]
        is_bounded = (np.abs(heard.marks) <= FARTHEST).all(axis=1) & (heard.marks[:, 2] > 0.0)
        heard = heard.where(is_bounded & (~is_own | (heard.period == NOW)))
        if not np.isin(heard.ids, table.ids).all():
            table = tables.grown(table, heard.ids, self._own, int(epoch.min()) - REMEMBERED)
        heard = heard.where(self._is_near(table, heard, epoch))
        key = (heard.period * len(epoch) + heard.rows) * (EMPTY + 1) + heard.ids
        is_first = np.zeros(len(key), dtype=np.bool_)
        is_first[np.unique(key, return_index=True)[1]] = True
        heard = heard.where(is_first)
        heard = heard.where(self._fits(table, heard))
        epochs = epoch[heard.rows] + heard.period
        return tables.with_heard(table, heard.period, heard.rows, heard.ids, epochs, heard.marks)

    def _unknown(self, table: Table, epoch: Ints, around: Neighborhood) -> Heard:
        """The marks in the beacons of the previous tick, of a period that counts, that their hearers do not know."""
        contacts = around.contacts
        positions = np.flatnonzero(around.is_heard)
        message = np.ascontiguousarray(contacts.declared[positions, : self.size]).view(self._layout)[:, 0]
        rows, ids = contacts.edges.rows[positions], message["marks"]["id"]
        period = (message["epoch"].astype(np.int64) - epoch[rows] + _WRAP // 2) % _WRAP - _WRAP // 2
        is_current = (period == NOW) | (period == NEXT)
        columns = self._columns(table).take(ids)
        is_known = table.is_known[np.where(is_current, period, NOW)[:, None], rows[:, None], columns]
        is_unknown = ~(is_known & (columns >= 0)) & (ids != EMPTY) & is_current[:, None]
        is_unknown[:, 0] &= ids[:, 0] == self._own_ids(contacts.edges.peers[positions])
        beacon, place = is_unknown.nonzero()
        marks = message["marks"]["mark"][beacon, place]
        return Heard(rows[beacon], period[beacon], ids[beacon, place].astype(np.int64), marks)

    def _columns(self, table: Table) -> Ints:
        """Column of each possible id in the table, or -1 [65536]; kept while the table has the same ids."""
        known, columns = self._lookup
        if known is not table.ids:
            columns = np.full(EMPTY + 1, -1)
            columns[table.ids] = np.arange(len(table.ids))
            self._lookup = table.ids, columns
        return columns

    def _is_near(self, table: Table, heard: Heard, epoch: Ints) -> Bools:
        """True for marks to which a robot can have moved since its last mark [h].

        A robot is at most one period of motion from its last mark, and its next mark is at most one from the robot.
        It moves for the `since` periods between. So no mark of an honest robot is refused, however its body moves.
        """
        if self._farthest is None:
            return np.ones(len(heard.rows), dtype=np.bool_)
        columns = table.columns(heard.ids)
        since = np.abs(epoch[heard.rows] + heard.period - table.last_epoch[heard.rows, columns])
        dx, dy = (heard.marks[:, :2].astype(np.float64) - table.last_place[heard.rows, columns]).T
        is_near = geometry.separation(dx, dy) <= self._farthest * (since + 2) + ROUNDING
        result: Bools = is_near | (since > REMEMBERED)
        return result

    def _fits(self, table: Table, heard: Heard) -> Bools:
        """True for marks with which a robot knows at most the maximum number of marks of a period [h]."""
        own = table.is_known[:, np.arange(len(self._own)), table.columns(self._own)]
        known = np.count_nonzero(table.is_known, axis=2) + ~own  # the robot's own mark has its place
        if len(heard.rows) + int(known.max()) <= self._most:
            return np.ones(len(heard.rows), dtype=np.bool_)
        group = heard.period * known.shape[1] + heard.rows
        order = group.argsort(kind="stable")
        sizes = np.bincount(group, minlength=known.size)
        rank = np.empty_like(group)
        rank[order] = np.arange(len(group)) - (np.cumsum(sizes) - sizes)[group[order]]
        result: Bools = (known.reshape(-1)[group] + rank < self._most) | (heard.ids == self._own[heard.rows])
        return result
