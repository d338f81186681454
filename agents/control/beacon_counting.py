"""Counting beacons: which of a peer's beacons decoded, which were missed, and at which separations.

A beacon slot is one Bernoulli sample of the channel. That a beacon decoded is known at once; that it was missed is
learnt from the gap before the next one that decodes, as a receiver learns it from sequence numbers.
"""

import numpy as np

from fes.arrays.types import Bools, Floats, Ints
from fes.model import objective
from fes.model.config import ObjectiveConfig
from fes.model.contacts import Contacts

MOST_MISSED = 10_000
"""Most slots that count of one silence, the latest ones: 200 s at 50 Hz, longer than a robot remembers them."""


def slots(before: Contacts, now: Contacts, tick: int, among: Bools) -> tuple[Ints, Floats, Bools]:
    """The beacon slots [s] learnt of at this tick: position of the contact, separation [m], decoded or missed.

    `among` [m] says which contacts count. The separation at the time of a miss is interpolated between the decoded
    beacons on its two sides. The first beacon that decodes on a contact is no sample: those missed before it are
    unknown, so it would always be a success.
    """
    at = now.edges.places_in(before.edges) if now.edges is not before.edges else np.arange(len(now.edges))
    if len(before.edges) == 0:
        at = np.full(len(now.edges), -1)
    last = np.where(at >= 0, before.heard.take(at, mode="clip"), -1) if len(before.edges) else at
    fresh = np.flatnonzero((now.heard == tick - 1) & among & (last >= 0))
    if len(fresh) == 0:
        return fresh, np.zeros(0), np.zeros(0, dtype=np.bool_)
    missed = tick - 2 - last[fresh]
    counted = np.minimum(missed, MOST_MISSED)
    start = before.heard_separation[at[fresh]]
    end = now.heard_separation[fresh]
    which = np.repeat(np.arange(len(fresh)), counted)
    order = np.arange(len(which)) - np.repeat(np.cumsum(counted) - missed, counted) + 1
    between = start[which] + (end - start)[which] * order / (missed[which] + 1)
    decoded = np.concatenate([np.ones(len(fresh), dtype=np.bool_), np.zeros(len(which), dtype=np.bool_)])
    return np.concatenate([fresh, fresh[which]]), np.concatenate([end, between]), decoded


def sample(contacts: Contacts, tick: int, at: Ints, wish: ObjectiveConfig) -> Floats:
    """One sample of J of (16) for each contact of `at` [l]: S(r) if its beacon of the last tick decoded, else 0.

    Its mean is S(r) p(r) at the true separation r: all that (18) can be given by a radio.
    """
    heard = contacts.heard.take(at) == tick - 1
    return np.where(heard, objective.preference(contacts.separation.take(at), wish), 0.0)
