"""Least costs of routes between robots that relay each other's traffic, also after the loss of one robot."""

from collections.abc import Iterable, Iterator

import numpy as np

from fes.arrays.types import Bools, Floats


def relayed(costs: Floats, relays: Iterable[int]) -> Floats:
    """The least `costs` [n, n] once `relays` forward messages too: a step of Floyd and Warshall for each of them."""
    costs = costs.copy()
    for relay in relays:
        np.minimum(costs, np.add.outer(costs[:, relay], costs[relay]), out=costs)
    return costs


def without_each(costs: Floats, robots: range) -> Iterator[tuple[int, Floats]]:
    """Each of the `robots`, with the least costs [n, n] of the routes that all other robots relay.

    The robots outside of `robots` relay already in `costs`. One half of `robots` relays, and the other half is
    divided again. This takes n log n relays in all; a new search without each robot would take n^2.
    """
    if len(robots) == 1:
        yield robots[0], costs
        return
    middle = len(robots) // 2
    yield from without_each(relayed(costs, robots[middle:]), robots[:middle])
    yield from without_each(relayed(costs, robots[:middle]), robots[middle:])


def between(costs: Floats, lost: int | None = None) -> Floats:
    """The `costs` [n, n] of all ordered pairs of two robots [n (n - 1)], without the robot `lost`."""
    is_pair = ~np.eye(len(costs), dtype=bool)
    if lost is not None:
        is_pair[lost] = is_pair[:, lost] = False
    result: Floats = costs[is_pair]
    return result


def reaches_all(is_link: Bools) -> bool:
    """True if links between robots, given as a symmetric matrix [n, n], connect all of them."""
    reached = np.zeros(len(is_link), dtype=np.bool_)
    new = reached.copy()
    new[:1] = True
    while new.any():
        reached |= new
        new = is_link[new].any(axis=0) & ~reached
    return bool(reached.all())
