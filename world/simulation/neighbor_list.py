"""The pairs of robots within communication range.

A list of candidate pairs (a Verlet list) has a margin, and is valid until a robot has moved by half of it. Per tick
only the candidates' separations are measured. The search sorts robots into square cells, and examines a bounded
number of pairs at once, so memory grows only with the pairs in range.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any

import numpy as np

from fes.arrays import geometry, masks
from fes.arrays.edges import Edges
from fes.arrays.types import Bools, Floats, Ints

SMALL = 64
"""Largest team of which every pair is a permanent candidate, since maintaining a list would cost more."""

MARGIN = 0.2
"""Margin of the candidate list, as a fraction of the communication range."""

BLOCK = 2**16
"""Approximate number of pairs that are examined at once."""

_FARTHEST_CELL = math.ldexp(1.0, 61)
"""Largest number of a cell. There a double's spacing is hundreds of cells: only coinciding robots are in range."""

_NEAR_CELLS = ((0, 0), (1, 0), (-1, 1), (0, 1), (1, 1))


@dataclass(frozen=True, eq=False)
class Candidates:
    """Pairs of rows (a < b) that may be in range [p], sorted."""

    a: Ints
    b: Ints
    positions: Floats | None
    """The robots' positions when the list was made [n, 2]; None for a permanent list."""
    reach: float
    """The communication range of the list [m]."""


@dataclass(frozen=True, eq=False)
class Proximity:
    """The pairs in range at one tick."""

    candidates: Candidates
    mask: Bools
    """True for a candidate in range [p]."""
    edges: Edges
    """The pairs in range, in both directions [m]; the same object while neither they nor the list change."""
    pair: Ints
    """Position of each edge's pair among the candidates [m]."""
    separation: Floats
    """Separation of the candidates [p] [m]."""

    @cached_property
    def least(self) -> float:
        """The smallest of these [m], infinite without any; NaN, of robots at infinity, does not count."""
        return _least(self.separation)

    def __getstate__(self) -> dict[str, Any]:
        # The smallest separation is computed again on demand.
        return {field.name: getattr(self, field.name) for field in fields(self)}


def measure(ids: Ints, poses: Floats, reach: float, before: Proximity | None) -> Proximity:
    """The pairs of robots at most `reach` [m] apart, given the pairs of the tick before."""
    candidates = before.candidates if before and _is_valid(before.candidates, poses, reach) else find(poses, reach)
    x, y = poses[:, geometry.X], poses[:, geometry.Y]
    separation = geometry.separation(
        x.take(candidates.a) - x.take(candidates.b), y.take(candidates.a) - y.take(candidates.b)
    )
    mask = separation <= reach
    if before and before.candidates is candidates and np.array_equal(mask, before.mask):
        return replace(before, separation=separation)
    return Proximity(candidates, mask, *_edges(ids, candidates, np.flatnonzero(mask)), separation)


def _edges(ids: Ints, candidates: Candidates, near: Ints) -> tuple[Edges, Ints]:
    """The pairs at positions `near` of `candidates`, in both directions, and the position of each edge's pair [m]."""
    a, b = candidates.a[near], candidates.b[near]
    rows, columns = np.concatenate([a, b]), np.concatenate([b, a])
    order = np.argsort(rows * len(ids) + columns)
    return Edges(ids, rows[order], ids[columns[order]]), np.concatenate([near, near])[order]


def _is_valid(candidates: Candidates, poses: Floats, reach: float) -> bool:
    """True if candidates contain all pairs within `reach` [m] at `poses` [n, 3]."""
    if candidates.positions is None:
        return True
    if candidates.reach != reach:
        return False
    moved = poses[:, :2] - candidates.positions
    return bool((geometry.separation(moved[:, 0], moved[:, 1]) <= 0.5 * MARGIN * reach).all())


def find(poses: Floats, reach: float) -> Candidates:
    """A list of candidates for `reach` [m], of robots at `poses` [n, 3]."""
    n = len(poses)
    if n <= SMALL:
        a, b = np.triu_indices(n, 1)
        return Candidates(a, b, None, reach)
    blocks = [pairs for *pairs, _ in _blocks(poses, (1.0 + MARGIN) * reach)]
    left, right = (np.concatenate(ends) for ends in zip(*blocks, strict=True))
    a, b = np.minimum(left, right), np.maximum(left, right)
    sort = np.argsort(a * n + b)
    return Candidates(a[sort], b[sort], poses[:, :2].copy(), reach)


def smallest(near: Proximity, poses: Floats, present: Bools, below: float) -> float:
    """The smaller of `below` [m] and the smallest separation [m] of two robots `present` [n] at `poses` [n, 3].

    `near` are the pairs in range at these poses. The candidates contain all pairs within the range of their list. So
    all robots are searched only while no two of them have been in range.
    """
    candidates, least = near.candidates, near.least
    if not masks.is_full(present):
        least = _least(near.separation[present.take(candidates.a) & present.take(candidates.b)])
    least = min(below, least)
    if candidates.positions is None or least <= candidates.reach:
        return least
    return _closest(poses[present], candidates.reach, least)


def _least(separation: Floats) -> float:
    """The smallest separation that is a number, infinite without any."""
    return float(np.minimum.reduce(separation[separation < math.inf], initial=math.inf))


def _closest(poses: Floats, side: float, least: float) -> float:
    """Smallest separation [m] of robots at `poses` [k, 3], more than `side` [m] apart, if it is below `least` [m]."""
    while side < least and len(poses) > 1 and math.isfinite(side):
        side = min(2.0 * side, least)
        for left, right, _ in _blocks(poses, side):
            apart = geometry.separation(*(poses[left, axis] - poses[right, axis] for axis in (0, 1)))
            least = float(np.minimum.reduce(apart, initial=least))
    return least


def count(poses: Floats, reach: float, most: int) -> int:
    """Number of directed pairs of robots at most `reach` [m] apart; where it is more than `most`, an estimate."""
    n, pairs, rows = len(poses), 0, 0
    for left, _, done in _blocks(poses, reach):
        pairs, rows = pairs + 2 * len(left), rows + done
        if pairs > most:
            return min(round(pairs / rows * n), n * (n - 1))
    return pairs


def _blocks(poses: Floats, side: float) -> Iterator[tuple[Ints, Ints, int]]:
    """The pairs of robots at most `side` [m] apart, each once, in blocks: both rows of each pair, and the number of
    rows of the block."""
    n = len(poses)
    with np.errstate(over="ignore"):
        cells = np.clip(np.floor(poses[:, :2] / side), -_FARTHEST_CELL, _FARTHEST_CELL).astype(np.int64)
    cells -= cells.min(axis=0) - 1
    width = int(cells[:, 0].max()) + 2
    code = cells[:, 1] * width + cells[:, 0]
    order = np.argsort(code, kind="stable")
    ordered = code[order]
    spans = []
    for dx, dy in _NEAR_CELLS:
        cell = code + dy * width + dx
        spans.append((np.searchsorted(ordered, cell, "left"), np.searchsorted(ordered, cell, "right")))
    ends = np.cumsum(np.add.reduce([last - first for first, last in spans]))
    for rows in np.split(np.arange(n), np.searchsorted(ends, np.arange(BLOCK, ends[-1], BLOCK))):
        parts = [
            _between(order, rows, first[rows], last[rows], own=step == (0, 0))
            for step, (first, last) in zip(_NEAR_CELLS, spans, strict=True)
        ]
        left, right = (np.concatenate(ends) for ends in zip(*parts, strict=True))
        apart = geometry.separation(
            poses[left, geometry.X] - poses[right, geometry.X], poses[left, geometry.Y] - poses[right, geometry.Y]
        )
        yield left[apart <= side], right[apart <= side], len(rows)


def _between(order: Ints, rows: Ints, first: Ints, last: Ints, own: bool) -> tuple[Ints, Ints]:
    """All pairs of a robot of `rows` and a robot at the positions `first` to `last` [rows] of `order`. Pairs within
    their `own` cell occur only once."""
    counts = last - first
    left = np.repeat(rows, counts)
    offset = np.arange(len(left)) - np.repeat(np.cumsum(counts) - counts, counts)
    right = order[np.repeat(first, counts) + offset]
    return (left[left < right], right[left < right]) if own else (left, right)
