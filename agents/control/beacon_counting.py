"""Beacons as samples of the channel: which of a peer's beacons decoded, which were missed, and at which separations.

A beacon slot is one Bernoulli sample of the channel. A decoded beacon is known at once. Missed beacons become known
when the next one decodes: a receiver infers them from the gap in the sequence numbers.
"""

import numpy as np

from fes.arrays.types import Bools, Floats, Ints
from fes.model import objective
from fes.model.config import ObjectiveConfig
from fes.model.contacts import NEVER, Contacts

MOST_MISSED = 10_000
"""Largest number of slots that one silence adds, the latest ones: 200 s at 50 Hz, longer than a robot's memory."""


def slots(before: Contacts, now: Contacts, tick: int, is_counted: Bools) -> tuple[Ints, Floats, Bools]:
    """The beacon slots that become known at this tick: position of the contact, separation [m], True if decoded.

    Each of the three arrays has one entry per slot. Only the contacts `is_counted` [m] are counted. The separation of
    a missed beacon is interpolated between the decoded beacons before and after it. The first decoded beacon of a
    contact is not a sample. The number of beacons missed before it is unknown, so it would always be a success.
    """
    transition = now.edges.after(before.edges)
    last = transition.carry(before.heard, NEVER)
    fresh = np.flatnonzero((now.heard == tick - 1) & is_counted & (last >= 0))
    if len(fresh) == 0:
        return fresh, np.zeros(0), np.zeros(0, dtype=np.bool_)
    missed = tick - 2 - last[fresh]
    counted = np.minimum(missed, MOST_MISSED)
    start = before.heard_separation[transition.positions[fresh]]
    end = now.heard_separation[fresh]
    silence = np.repeat(np.arange(len(fresh)), counted)
    order = np.arange(len(silence)) - np.repeat(np.cumsum(counted) - missed, counted) + 1
    between = start[silence] + (end - start)[silence] * order / (missed[silence] + 1)
    decoded = np.concatenate([np.ones(len(fresh), dtype=np.bool_), np.zeros(len(silence), dtype=np.bool_)])
    return np.concatenate([fresh, fresh[silence]]), np.concatenate([end, between]), decoded


def sample(contacts: Contacts, tick: int, positions: Ints, config: ObjectiveConfig) -> Floats:
    """One sample of J of (16) for the contacts at `positions` [l]: S(r) if the last tick's beacon decoded, else 0.

    Its mean is S(r) p(r) at the true separation r. A real radio cannot give (18) a better sample.
    """
    heard = contacts.heard.take(positions) == tick - 1
    return np.where(heard, objective.preference(contacts.separation.take(positions), config), 0.0)
