"""The fate of each datagram: which robots receive it. Pure: addresses, positions and draws come in as arguments."""

from typing import Generic, TypeVar

import numpy as np

from fes.arrays.types import Floats, Ints
from world.tabletop.radio.reachability import Reach

Address = TypeVar("Address")


class Relay(Generic[Address]):
    """Addresses of robots, as their datagrams show them, and the counts of each directed pair."""

    def __init__(self, robots: int, reach: Reach) -> None:
        self.reach = reach
        """The pairs in range now."""
        self.sent: Ints = np.zeros((robots, robots), dtype=np.int64)
        """Datagrams of a sender while a receiver with a known address was in range [n, n]."""
        self.forwarded: Ints = np.zeros((robots, robots), dtype=np.int64)
        """Those that were forwarded to the receiver [n, n]."""
        self.foreign = 0
        """Datagrams of no robot of this team."""
        self._addresses: list[Address | None] = [None] * robots

    def receivers(self, sender: int | None, address: Address, draws: Floats) -> list[Address]:
        """The addresses that get a datagram of `sender`, which came from `address`.

        `draws` [n] are uniform numbers in [0, 1), one per receiver. None stands for a datagram without a sender.
        """
        if sender is None or not 0 <= sender < len(self._addresses):
            self.foreign += 1
            return []
        self._addresses[sender] = address
        known = np.array([peer is not None for peer in self._addresses])
        known[sender] = False
        sent = known & self.reach.in_range[sender]
        passed = sent & (draws < self.reach.probability[sender])
        self.sent[sender] += sent
        self.forwarded[sender] += passed
        return [peer for robot in np.flatnonzero(passed) if (peer := self._addresses[robot]) is not None]
