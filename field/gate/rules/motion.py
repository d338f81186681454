"""A check that the pose moves as commanded: it detects wrong units, reversed frames, and wheels without power.

Travel along the heading and turn are compared with the integrals of the commands, in parts of the window. The factor
between them is a least-squares slope: 1 for a perfect body, 0 for one that stands, -1 for a reversed axis. Bodies
slip, saturate and lag, so a factor from 1/3 to 3 at any lag up to 0.3 s passes.
"""

import math
from typing import NamedTuple

from field.gate.rules.frames import Pose, Twist, wrapped
from field.gate.rules.settings import Limits

SPACING = 0.05
"""Duration of one sample [s]."""

LAGS = 7
"""Lags that are tried, 0 to 0.3 s in steps of one sample."""

PARTS = 4
"""Parts of the window that are compared."""

WALKING, TURNING = 0.25, 0.4
"""Mean velocities from which on a window is judged, as shares of the limits: noise of the pose is small beside them.
The share of turns is larger. Commanded turns alternate fast, so little of them is left after a lag."""

LARGEST_FACTOR = 3.0


class Sample(NamedTuple):
    """Sums over one sample: what was commanded, and what the pose did [m of the body, rad]."""

    commanded_travel: float = 0.0
    commanded_turn: float = 0.0
    travel: float = 0.0
    turn: float = 0.0


class Motion(NamedTuple):
    """The samples of the last window."""

    samples: tuple[Sample, ...] = ()
    current: Sample = Sample()
    """The sample that is being summed up."""
    begun: float = -math.inf
    """Time at which it began [s]."""
    updated: float = -math.inf
    """Time of the last update [s]."""
    pose: Pose | None = None
    """The pose at the last update [m of the body]."""


def updated(motion: Motion, window: float, now: float, twist: Twist, pose: Pose) -> Motion:
    """The motion after an update at `now` [s]: `twist` was commanded since the last one."""
    if motion.pose is None:
        return Motion(begun=now, updated=now, pose=pose)
    x, y, heading = motion.pose
    turn = wrapped(pose[2] - heading)
    middle = heading + turn / 2
    dt = now - motion.updated
    current = Sample(
        motion.current.commanded_travel + twist[0] * dt,
        motion.current.commanded_turn + twist[1] * dt,
        motion.current.travel + (pose[0] - x) * math.cos(middle) + (pose[1] - y) * math.sin(middle),
        motion.current.turn + turn,
    )
    if now - motion.begun < SPACING:
        return motion._replace(current=current, updated=now, pose=pose)
    samples = (*motion.samples, current)[-(_length(window) + LAGS - 1) :]
    begun = max(motion.begun + SPACING, now - SPACING)  # equally spaced, unless the loop was late
    return Motion(samples, Sample(), begun, now, pose)


def problem(motion: Motion, window: float, limits: Limits) -> str:
    """The reason why the pose does not move as commanded, in one line; empty if it does, or was hardly commanded."""
    length = _length(window)
    if len(motion.samples) < length + LAGS - 1:
        return ""
    columns = list(zip(*motion.samples, strict=True))
    for name, least, commanded, measured in (
        ("travels", WALKING * limits.linear, columns[0], columns[2]),
        ("turns", TURNING * limits.angular, columns[1], columns[3]),
    ):
        parts = _parts(measured, length, 0)
        factors = []
        for lag in range(LAGS):
            wanted = _parts(commanded, length, lag)
            if sum(map(abs, wanted)) < least * length * SPACING:
                break  # a lag at which the body was hardly commanded proves nothing
            products = sum(first * second for first, second in zip(wanted, parts, strict=True))
            factors.append(products / sum(first * first for first in wanted))
        if len(factors) == LAGS and not any(1 / LARGEST_FACTOR <= factor <= LARGEST_FACTOR for factor in factors):
            return f"the pose {name} {factors[0]:.2g} times as far as commanded within {window:g} s"
    return ""


def _length(window: float) -> int:
    """Samples that are compared, the same number in each part; they and those of the lags fill a window."""
    return PARTS * max(1, (round(window / SPACING) - LAGS + 1) // PARTS)


def _parts(values: tuple[float, ...], length: int, lag: int) -> list[float]:
    """Sums of the parts of the window that ended `lag` samples ago."""
    end = len(values) - lag
    size = length // PARTS
    return [sum(values[first : first + size]) for first in range(end - length, end, size)]
