"""The operator's permission to move: Permits of one operator at a time, each counted once, and only if not delayed.

The clocks of gate and operator differ by an unknown offset. So the age of a Permit is its delay beyond that of the
fastest Permit of its operator.
"""

import math
from typing import NamedTuple

from fes.protocol.robot_control import Permit

MAX_OPERATORS = 256
"""Operators whose Permits are distinguished; a further one replaces the one that was heard least recently."""

DRIFT = 1e-3
"""Largest drift of two clocks that does not count as a growing delay [1]."""

PAUSE = 3.0
"""Time without a Permit after which delays are compared anew [s]. A silent link is closed before, so that none of its
Permits arrives later. The clock of a machine that sleeps may stand still."""


class Heard(NamedTuple):
    """The Permits of one operator."""

    sequence: int
    """The highest number."""
    offset: float
    """Arrival on the gate's clock less sending on the operator's, of the fastest Permit [s]."""
    arrival: float
    """Time of the last arrival [s]."""


class Permits(NamedTuple):
    """The Permits that a gate has heard."""

    arrival: float = -math.inf
    """Arrival of the last one that counts [s]."""
    operator: int = -1
    """Its operator."""
    heard: dict[int, Heard] = {}  # noqa: RUF012 - replaced, never changed
    """The Permits of each operator, the most recently heard one last."""


def received(permits: Permits, longest: float, now: float, permit: Permit) -> Permits:
    """The Permits after one has arrived at `now` [s], of which each holds for `longest` [s].

    One that is older than `longest` does not count, nor does one of another operator while a Permit holds.
    """
    known = permits.heard.get(permit.operator)
    if permit.operator != permits.operator and is_held(permits, longest, now):
        return permits
    if known is not None and permit.sequence <= known.sequence:
        return permits
    offset = fastest = now - permit.sent_at / 1e9
    if known is not None and now - known.arrival <= PAUSE:
        fastest = min(offset, known.offset + DRIFT * (now - known.arrival))
    others = [entry for entry in permits.heard.items() if entry[0] != permit.operator]  # none of them holds now
    heard = dict([*others[1 - MAX_OPERATORS :], (permit.operator, Heard(permit.sequence, fastest, now))])
    if offset - fastest > longest:
        return permits._replace(heard=heard)
    return Permits(now, permit.operator, heard)


def is_held(permits: Permits, longest: float, now: float) -> bool:
    """True if the robot may move at `now` [s]."""
    return now - permits.arrival <= longest
