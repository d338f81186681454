"""The state of a gate, and a command from the agent. Times are of the gate's monotonic clock."""

import math
from typing import NamedTuple

from field.gate.rules.frames import Pose, Twist
from field.gate.rules.motion import Motion
from field.gate.rules.permits import Permits
from field.gate.rules.pose_guard import Seen

ZERO = (0.0, 0.0)


class Order(NamedTuple):
    """A command from the agent, in the law's units."""

    sequence: int
    computed_at: float
    """Time at which its computation ended [s]."""
    linear: float
    angular: float
    heard_at: float
    """Time at which the robot heard a peer last [s]; -inf before the first."""


class Gate(NamedTuple):
    """The state of a gate."""

    zero: int = 0
    """Reading of the gate's clock at time 0 [ns]: a random number, so that no other gate's readings match."""
    twist: Twist = ZERO
    """The twist that goes to the body now."""
    wanted: Twist = ZERO
    """The last good command, clipped."""
    computed_at: float = -math.inf
    """Time at which it was computed [s]."""
    sequence: int = -1
    since: float = -math.inf
    """Only commands that are computed after this time count [s]."""
    latch: str = "not started"
    """Why it is stopped; empty if it is not."""
    hold: str = ""
    """Why it commands zero at present; empty if it does not."""
    is_started: bool = False
    """True from the first start on: before it, nothing is published."""
    updated: float = -math.inf
    """Time of the last twist [s]."""
    seen: Seen | None = None
    pose: Pose | None = None
    """The pose at `posed_at`, from `seen` and the twists since then [team frame, full size]."""
    posed_at: float = -math.inf
    """[s]"""
    problem: str = ""
    """Why the last pose is not usable; empty if it is."""
    heard_at: float = -math.inf
    rival_at: float = -math.inf
    permits: Permits = Permits()
    motion: Motion = Motion()
    accepted: int = 0
    refused: int = 0
