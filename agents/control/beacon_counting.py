"""Beacons as samples of the channel: which of a peer's beacons decoded, which were missed, and at which separations.

A beacon slot is one Bernoulli sample of the channel. A decoded beacon is known at once. A missed one shows in the gap
before the next that decodes, as a receiver infers it from sequence numbers.
"""

import numpy as np

from fes.arrays.types import Bools, Floats, Ints
from fes.model import objective
from fes.model.config import ObjectiveConfig
from fes.model.contacts import NEVER, Contacts

MOST_MISSED = 10_000
"""Most slots of one silence that count, the latest ones: 200 s at 50 Hz, longer than the memory of a robot."""


def slots(before: Contacts, now: Contacts, tick: int, is_counted: Bools) -> tuple[Ints, Floats, Bools]:
    """The beacon slots [s] that become known at this tick: position of the contact, separation [m], True if decoded.

    Only the contacts `is_counted` [m] are counted. The separation of a missed beacon is interpolated between the
    decoded beacons before and after it. The first decoded beacon of a contact is not a sample: the number of those
    missed before it is unknown, so it would always be a success.
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

    Its mean is S(r) p(r) at the true separation r: no radio can give (18) more.
    """
    heard = contacts.heard.take(positions) == tick - 1
    return np.where(heard, objective.preference(contacts.separation.take(positions), config), 0.0)
