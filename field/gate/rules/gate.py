"""The gate between the agent's commands and the wheels: events and the time come in, a bounded twist goes out.

The robot moves only while nothing holds or stops it. A hold lasts as long as its cause; a stop is latched, until a
person starts the robot again.

| cause                                                               | effect  |
|---------------------------------------------------------------------|---------|
| not started yet, or stopped by the operator                         | stopped |
| the operator's permit has lapsed                                    | stopped |
| the pose is outside the fence, or within its braking distance       | stopped |
| a pose of a wrong frame, or a payload of a wrong type               | stopped |
| the pose jumps farther than the body can move                       | stopped |
| another program commands the body                                   | stopped |
| the pose does not move as commanded (`motion`)                      | stopped |
| the agent has ended, or the gate itself is told to end              | stopped |
| no fresh pose: none arrives, or its stamp stands still or goes back | held    |
| the gate's own loop was late                                        | held    |
| no beacon of a peer for a set time                                  | held    |
| no fresh command: the agent hangs, or its last one is too old       | held    |

Three rules keep stale commands away from the wheels. A command counts only if it is newer than the last one, and not
older than `timing.age`. It must be computed after the last moment at which a cause other than a missing command held
or stopped the robot. The last good command counts only until its timeout.

Under any cause the robot slows down with its largest acceleration a. So after any event it travels at most
v²/2a + v (timeout + 2 period). Everything here is in the body's units, except poses: they are in the team frame.
"""

import math

from fes.protocol.robot_control import HELD, RUNNING, STOPPED, GateStatus, Permit, Start
from fes.ros.messages import PoseMessage
from field.gate.rules import fence, frames, motion, permits, pose_guard
from field.gate.rules.frames import Twist
from field.gate.rules.motion import Motion
from field.gate.rules.settings import Settings
from field.gate.rules.state import ZERO, Gate, Order

NANO = 1_000_000_000

RIVAL = 1.0
"""Time after the last command of another program before which the robot cannot start [s]."""

START_AGE = 1.0
"""Largest age of a start [s]: after a longer delay, a person no longer expects the robot to move."""


def commanded(gate: Gate, settings: Settings, now: float, order: Order) -> Gate:
    """The gate after a command from the agent has arrived at `now` [s]."""
    if gate.heard_at < order.heard_at <= now:
        gate = gate._replace(heard_at=order.heard_at)
    linear, angular = frames.to_body_twist(settings.placement, order.linear, order.angular)
    is_young = gate.since < order.computed_at and 0 <= now - order.computed_at <= settings.timing.age
    if order.sequence <= gate.sequence or not is_young or not (math.isfinite(linear) and math.isfinite(angular)):
        return gate._replace(refused=gate.refused + 1)
    if gate.latch:
        return gate
    wanted = settings.limits.clipped(linear, angular)
    gate = gate._replace(wanted=wanted, computed_at=order.computed_at, sequence=order.sequence)
    return gate._replace(accepted=gate.accepted + 1)


def permitted(gate: Gate, settings: Settings, now: float, permit: Permit) -> Gate:
    """The gate after a Permit has arrived at `now` [s]."""
    return gate._replace(permits=permits.received(gate.permits, settings.timing.permit, now, permit))


def stopped(gate: Gate, reason: str) -> Gate:
    """The gate after a stop; the first reason stays."""
    return gate if gate.latch and gate.is_started else _forgotten(gate)._replace(latch=reason, hold="")


def posed(gate: Gate, settings: Settings, now: float, message: PoseMessage) -> Gate:
    """The gate after a pose of the body has arrived at `now` [s]."""
    seen = pose_guard.seen(settings, now, message)
    if problem := pose_guard.format_problem(settings, message.frame, seen):
        return faulted(gate, problem)
    is_latched = gate.latch != ""
    if pose_guard.is_stale(gate.seen, seen, is_latched=is_latched):
        return gate
    problem = pose_guard.problem(settings, gate.seen, seen, is_latched=is_latched)
    gate = gate._replace(seen=seen, pose=seen.pose, posed_at=seen.received_at, problem=problem)
    return faulted(gate, problem) if problem else gate


def faulted(gate: Gate, problem: str) -> Gate:
    """The gate after a pose that cannot be right: it stops a robot that runs, and prevents the start of another."""
    gate = gate._replace(problem=problem)
    return gate if gate.latch else stopped(gate, problem)


def rivaled(gate: Gate, now: float, key: str) -> Gate:
    """The gate after another program has commanded the body on `key`."""
    gate = gate._replace(rival_at=now)
    return gate if gate.latch else stopped(gate, f"another program commands the body on {key}")


def started(gate: Gate, settings: Settings, now: float, start: Start) -> tuple[Gate, str]:
    """The gate after a start, and why it is refused; empty if it is not. A robot that runs stays as it is."""
    if not gate.latch:
        return gate, ""
    if not 0 <= clock(gate, now) - start.clock <= NANO * START_AGE:
        return gate, f"the start took more than {START_AGE:g} s to arrive"
    if not _has_permit(gate, settings, now):
        return gate, "the operator's permit is missing"
    if gate.problem:
        return gate, gate.problem
    if gate.seen is None or not _has_pose(gate, settings, now):
        return gate, "no fresh pose arrives from the body"
    if now - gate.rival_at <= RIVAL:
        return gate, "another program commands the body"
    fresh = _forgotten(gate)._replace(latch="", hold="", since=now, is_started=True, motion=Motion())
    return fresh, ""


def updated(gate: Gate, settings: Settings, now: float, late: float) -> Gate:
    """The gate with the twist to send at `now` [s]; its loop is `late` [s]."""
    timing = settings.timing
    if not gate.latch and not _has_permit(gate, settings, now):
        gate = stopped(gate, "the operator's permit has lapsed")
    hold = "" if gate.latch else _cause(gate, settings, now, late)
    if gate.latch or hold:
        gate = _forgotten(gate)._replace(since=now)
    elif not now - gate.computed_at <= timing.timeout:
        hold = f"no command from the agent for {timing.timeout:g} s"
    gate = _moved(gate._replace(hold=hold), settings, now)
    twist = _next_twist(gate, settings, now, ZERO if gate.latch or hold else gate.wanted)
    if gate.pose and not gate.latch and (problem := fence.braking_problem(settings, gate.pose, twist)):
        gate = stopped(gate, problem)._replace(since=now)
        twist = _next_twist(gate, settings, now, ZERO)
    return _checked(gate._replace(updated=now), settings, now)._replace(twist=twist)


def status(gate: Gate, settings: Settings, now: float) -> GateStatus:
    """The state in the words of an operator, at full size."""
    seen = gate.seen
    return GateStatus(
        settings.robot,
        STOPPED if gate.latch else HELD if gate.hold else RUNNING,
        gate.latch or gate.hold,
        (0.0, 0.0, 0.0) if seen is None else seen.pose,
        -1.0 if seen is None else max(0.0, now - seen.received_at),
        frames.to_team_twist(settings.placement, *gate.twist),
        gate.accepted,
        gate.refused,
        clock(gate, now),
    )


def clock(gate: Gate, now: float) -> int:
    """Reading of the gate's clock at `now` [ns]."""
    return gate.zero + round(NANO * now)


def _cause(gate: Gate, settings: Settings, now: float, late: float) -> str:
    """The reason to hold the robot, other than an absent command; empty without any."""
    timing = settings.timing
    if late > timing.lateness:
        return f"the gate's own loop is late by {1000 * late:.0f} ms"
    if not _has_pose(gate, settings, now):
        return f"no fresh pose for {timing.pose_age:g} s"
    if timing.silence is not None and not now - gate.heard_at <= timing.silence:
        return f"no robot is heard for {timing.silence:g} s"
    return ""


def _moved(gate: Gate, settings: Settings, now: float) -> Gate:
    """The gate with the pose at `now` [s], after the twist that went out."""
    if gate.pose is None or now <= gate.posed_at:
        return gate
    pose = frames.moved(settings.placement, gate.pose, gate.twist, now - gate.posed_at)
    return gate._replace(pose=pose, posed_at=now)


def _next_twist(gate: Gate, settings: Settings, now: float, wanted: Twist) -> Twist:
    """The twist to send at `now` [s] on the way to a wanted one."""
    dt = max(0.0, min(now - gate.updated, settings.timing.longest_period))
    return settings.limits.approached(gate.twist, wanted, dt)


def _checked(gate: Gate, settings: Settings, now: float) -> Gate:
    """The gate after the check of the body's motion under the twist that went out until `now` [s]."""
    window, scale = settings.timing.motion_check, settings.placement.scale
    if gate.latch or gate.seen is None or window is None:
        return gate
    x, y, heading = gate.seen.pose
    moved = motion.updated(gate.motion, window, now, gate.twist, (x / scale, y / scale, heading))
    is_complete = moved.samples is not gate.motion.samples  # a sample: only then may the judgment change
    problem = motion.problem(moved, window, settings.limits) if is_complete else ""
    gate = gate._replace(motion=moved)
    return stopped(gate, problem) if problem else gate


def _forgotten(gate: Gate) -> Gate:
    """The gate without its last command."""
    return gate._replace(wanted=ZERO, computed_at=-math.inf)


def _has_permit(gate: Gate, settings: Settings, now: float) -> bool:
    return permits.is_held(gate.permits, settings.timing.permit, now)


def _has_pose(gate: Gate, settings: Settings, now: float) -> bool:
    return gate.seen is not None and now - gate.seen.received_at <= settings.timing.pose_age
