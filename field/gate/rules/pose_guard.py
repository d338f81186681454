"""The rules that a pose must keep before anything relies on it: frame, stamp, distance and fence."""

import math
from typing import NamedTuple

from fes.ros.messages import PoseMessage
from field.gate.rules import fence, frames
from field.gate.rules.frames import Pose, Twist
from field.gate.rules.settings import Settings

UNKNOWN = (math.nan, math.nan)
"""The twist of a body whose pose has none."""


class Seen(NamedTuple):
    """A pose in the team frame, at full size."""

    received_at: float
    """Time of its arrival [s, monotonic]."""
    stamp: int
    """Time on the clock of its driver [ns]; 0 if it has none."""
    pose: Pose
    twist: Twist
    """Twist that the driver measured, at full size; NaN if there is none."""


def seen(settings: Settings, now: float, message: PoseMessage) -> Seen:
    """A pose of the body that arrived at `now` [s], in the team frame."""
    pose = frames.to_team(settings.placement, message.x, message.y, message.heading)
    twist = UNKNOWN if message.twist is None else frames.to_team_twist(settings.placement, *message.twist)
    return Seen(now, message.stamp, pose, twist)


def is_stale(last: Seen | None, new: Seen, *, is_latched: bool) -> bool:
    """True if the stamp of a pose stands still or goes back: a localization that hangs, or a recording that restarts.

    A stopped robot accepts a stamp that goes back, since someone may have set the clock.
    """
    if last is None or new.stamp == 0:
        return False
    return new.stamp == last.stamp or (new.stamp < last.stamp and not is_latched)


def format_problem(settings: Settings, frame: str, new: Seen) -> str:
    """The reason why a pose cannot be used at all: a wrong frame, or numbers out of range; empty if it can."""
    expected = settings.body.frame
    if frame != expected:
        return f"the pose must be in frame '{expected}', got '{shown(frame)}'"
    is_finite = all(map(math.isfinite, new.pose)) and not any(map(math.isinf, new.twist))
    return "" if is_finite else "the pose and its twist must be finite at full size"


def shown(text: str) -> str:
    """The first characters of a foreign text, without those that cannot be printed."""
    return "".join(letter if letter.isprintable() else "?" for letter in text[:60])


def problem(settings: Settings, last: Seen | None, new: Seen, *, is_latched: bool) -> str:
    """The reason why a pose cannot be right, in one line; empty if it can. A person may carry a stopped robot."""
    x, y, _ = new.pose
    if not fence.is_inside(settings.fence, x, y):
        return f"the pose is outside the fence: {x:.2f}, {y:.2f} m"
    if last is None or is_latched:
        return ""
    distance, most = math.dist(last.pose[:2], (x, y)), settings.placement.scale * _reach(settings, last, new)
    return f"the pose jumps by {distance:.2f} m, more than {most:.2f} m" if distance > most else ""


def _reach(settings: Settings, last: Seen, new: Seen) -> float:
    """Largest distance between two poses that the body's limits allow [m of the body].

    Arrival times jitter by up to the largest age of a pose. Without poses the body stops, and then is not far.
    """
    limits, timing = settings.limits, settings.timing
    longest = timing.pose_age + timing.timeout + limits.linear / limits.acceleration
    elapsed = min(new.received_at - last.received_at, longest)
    return limits.linear * (elapsed + timing.pose_age) + limits.pose_jump
