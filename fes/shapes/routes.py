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


def reaches_all(is_link: Bools) -> Bools:
    """True for each graph, a symmetric matrix [..., n, n], whose links connect all its robots [...]."""
    is_joined = is_link[..., 0, :] | (np.arange(is_link.shape[-1]) == 0)
    while True:
        grown: Bools = is_joined | np.logical_or.reduce(is_link & is_joined[..., None], axis=-2)
        if np.count_nonzero(grown) == np.count_nonzero(is_joined):
            connected: Bools = np.logical_and.reduce(is_joined, axis=-1)
            return connected
        is_joined = grown
