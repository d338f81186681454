"""Shares of decoded packets by separation, with Wilson's score intervals."""

from typing import NamedTuple

import numpy as np

from console.fit.measurements import Packets
from fes.arrays.types import Floats, Ints

NORMAL = 1.959963984540054
"""Quantile of the normal distribution for 95 % between both sides [1]."""

MOST = 12
"""Largest number of shares."""

FEWEST = 20
"""Smallest number of packets per share, where separations are not repeated."""


class Shares(NamedTuple):
    """Shares of decoded packets, by separation."""

    separation: Floats
    """Mean separation, ascending [b] [m]."""
    sent: Ints
    decoded: Ints
    low: Floats
    """Ends of the intervals [b]."""
    high: Floats

    @property
    def share(self) -> Floats:
        """[b]"""
        share: Floats = self.decoded / self.sent
        return share


def by_separation(packets: Packets) -> Shares:
    """One share per separation where there are at most MOST, else shares of about equal numbers of packets."""
    separation = np.round(packets.separation, 3)
    distinct, group = np.unique(separation, return_inverse=True)
    if len(distinct) > MOST:
        count = max(2, min(MOST, len(separation) // FEWEST))
        edges = np.unique(np.quantile(separation, np.linspace(0.0, 1.0, count + 1)[1:-1]))
        group = np.unique(np.searchsorted(edges, separation, "right"), return_inverse=True)[1]
    sent = np.bincount(group)
    decoded = np.bincount(group, packets.decoded).astype(np.int64)
    return Shares(np.bincount(group, separation) / sent, sent, decoded, *wilson(decoded, sent))


def wilson(decoded: Ints, sent: Ints) -> tuple[Floats, Floats]:
    """Ends of the 95 % interval of a share [b] [b]; Wilson (1927)."""
    share, square = decoded / sent, NORMAL**2
    center = (share + square / (2 * sent)) / (1 + square / sent)
    half = NORMAL / (1 + square / sent) * np.sqrt(share * (1 - share) / sent + square / (4.0 * sent**2))
    # at 0 and 1 the end is the share itself
    return np.minimum(np.maximum(center - half, 0.0), share), np.maximum(np.minimum(center + half, 1.0), share)
