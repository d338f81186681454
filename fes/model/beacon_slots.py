"""Beacons as samples of the channel: which of a peer's beacons decoded, which were missed, and at which separations.

A beacon slot is one Bernoulli sample of the channel. A decoded beacon is known at once. Missed beacons become known
when the next one decodes: a receiver infers them from the gap in the sequence numbers.
"""

from typing import NamedTuple

import numpy as np

from fes.arrays.types import Bools, Floats, Ints
from fes.model.contacts import NEVER, Contacts

MOST_MISSED = 10_000
"""Largest number of slots that one silence adds, the latest ones: 200 s at 50 Hz, longer than a robot's memory."""


class Slots(NamedTuple):
    """Beacon slots [s]: each is one sample of the channel."""

    contact: Ints
    """Position of the peer among the contacts [s]."""
    separation: Floats
    """[s] [m]"""
    decoded: Bools
    """True for a beacon that decoded, False for one that was missed [s]."""


def between(before: Contacts, now: Contacts, tick: int, is_counted: Bools) -> Slots:
    """The beacon slots that become known at this tick, of the contacts `is_counted` [m].

    The separation of a missed beacon is interpolated between the decoded beacons before and after it. The first
    decoded beacon of a contact is not a sample. The number of beacons missed before it is unknown, so it would always
    be a success.
    """
    transition = now.edges.after(before.edges)
    last = transition.carry(before.heard, NEVER)
    fresh = np.flatnonzero((now.heard == tick - 1) & is_counted & (last >= 0))
    if len(fresh) == 0:
        return Slots(fresh, np.zeros(0), np.zeros(0, dtype=np.bool_))
    missed = tick - 2 - last[fresh]
    counted = np.minimum(missed, MOST_MISSED)
    start = before.heard_separation[transition.positions[fresh]]
    end = now.heard_separation[fresh]
    silence = np.repeat(np.arange(len(fresh)), counted)
    order = np.arange(len(silence)) - np.repeat(np.cumsum(counted) - missed, counted) + 1
    missing = start[silence] + (end - start)[silence] * order / (missed[silence] + 1)
    decoded = np.concatenate([np.ones(len(fresh), dtype=np.bool_), np.zeros(len(silence), dtype=np.bool_)])
    return Slots(np.concatenate([fresh, fresh[silence]]), np.concatenate([end, missing]), decoded)
