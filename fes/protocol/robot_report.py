"""RobotReport: one real robot to observers, several times per second. It holds the robot's belief, not the truth.

No robot subscribes to it. A decoder raises MessageError, and nothing else, on any bytes.
"""

from typing import Any, NamedTuple

import numpy as np

from fes.arrays.types import Floats, Ints
from fes.errors import MessageError
from fes.protocol import wire
from fes.protocol.messages import Command, decode_command, encode_command
from fes.protocol.robot_control import LONGEST_REASON, MODES

PERIOD = 0.1
"""Time between two RobotReports of a robot [s]."""

MAX_BOOT = 2**62
"""Largest number that an agent draws at its start."""

MAX_PEERS = 4096
"""Largest number of peers in a RobotReport, and of links."""

MAX_COUNT = 2**32
"""Largest count of the beacons of a peer: their sequence numbers have 32 bits."""

MAX_TIME = 1e9
"""Longest time since the start of an agent [s]."""

SHORTEST_TICK, LONGEST_TICK = 1e-4, 10.0
"""Bounds of the tick length [s]."""

NO_AGE = -1.0
"""Age of a pose before the first one."""


class Heard(NamedTuple):
    """Ticks of a robot since its agent started, for each peer: with its beacon, with a lost one, or concealed."""

    peers: Ints
    """Ascending [p]."""
    heard: Ints
    """Ticks with a beacon that decoded [p]."""
    missed: Ints
    """Ticks with a beacon that was lost [p]."""
    concealed: Ints
    """Ticks that repeat the verdict of an earlier one, because the peer or the network paused [p]."""
    estimates: Floats
    """The peer's own separation estimate of the link to this robot, from its last beacon [p] [m]; NaN without one."""


class RobotReport(NamedTuple):
    """The state of one real robot, as the robot itself knows it."""

    boot: int
    """A number that the agent has drawn at its start, from 0 to MAX_BOOT: counts begin anew with another one."""
    elapsed: float
    """Time since the agent started [s]."""
    dt: float
    """Tick length [s]."""
    pose: tuple[float, float, float]
    """Its belief: x, y, heading [m, m, rad; team frame, full size]; zeros before the first pose."""
    pose_age: float
    """Age of that pose [s]; NO_AGE before the first."""
    command: Command
    """Its last Command: own tick, id, twist, links, estimates and what it has learnt."""
    reference_separation: float
    """rho_0 of the learnt level [m]; 0 if the robot learns no level and exponent."""
    beacons: Heard
    """The beacons of its peers."""
    mode: str
    """Mode of its gate, one of `robot_control.MODES`; empty if the gate is silent."""
    reason: str
    """Why the gate is not running, in one line."""

    @property
    def robot(self) -> int:
        """The robot's id."""
        return self.command.robot

    @property
    def has_pose(self) -> bool:
        """True once the robot knows where it is."""
        return self.pose_age >= 0.0


def no_beacons() -> Heard:
    """The beacons of a robot that has heard of no peer."""
    none = np.zeros(0, dtype=np.int64)
    return Heard(none, none, none, none, np.zeros(0))


def encode_robot_report(report: RobotReport) -> bytes:
    """The payload of a RobotReport; a longer reason is cut."""
    beacons = report.beacons
    return wire.pack(
        report.boot,
        float(report.elapsed),
        float(report.dt),
        [float(value) for value in report.pose],
        float(report.pose_age),
        encode_command(report.command),
        float(report.reference_separation),
        wire.id_bytes(beacons.peers),
        [counts.astype("<i8").tobytes() for counts in (beacons.heard, beacons.missed, beacons.concealed)],
        beacons.estimates.astype("<f8").tobytes(),
        report.mode,
        report.reason[:LONGEST_REASON],
    )


def decode_robot_report(payload: bytes) -> RobotReport:
    """The RobotReport in a payload; raises MessageError."""
    name = "RobotReport"
    boot, elapsed, dt, pose, age, command, scale, peers, counts, estimates, mode, reason = wire.unpack(
        name, payload, 12
    )
    wire.check(name, type(boot) is int and 0 <= boot <= MAX_BOOT, "expects a number of a start", boot)
    wire.check(name, type(pose) is list and len(pose) == 3, "expects a pose", pose)
    x, y, heading = wire.finite(name, tuple(pose))
    last = _command(name, command)
    wire.check(name, mode == "" or (type(mode) is str and mode in MODES), "expects a mode", mode)
    is_short = type(reason) is str and len(reason) <= LONGEST_REASON and reason.isprintable()
    wire.check(name, is_short, "expects a reason in one line", reason)
    return RobotReport(
        boot,
        _between(name, elapsed, 0.0, MAX_TIME, "a time"),
        _between(name, dt, SHORTEST_TICK, LONGEST_TICK, "a tick length"),
        (x, y, heading),
        age if age == NO_AGE and type(age) is float else _between(name, age, 0.0, MAX_TIME, "the age of a pose"),
        last,
        _between(name, scale, 0.0, MAX_TIME, "a separation"),
        _heard(name, peers, counts, estimates),
        mode,
        reason,
    )


def _command(name: str, payload: Any) -> Command:
    wire.check(name, type(payload) is bytes, "expects a Command", payload)
    try:
        command = decode_command(payload)
    except MessageError as error:
        raise MessageError(name, str(error)) from None
    wire.check(name, len(command.links) <= MAX_PEERS, f"expects at most {MAX_PEERS} links", len(command.links))
    return command


def _heard(name: str, peers: Any, counts: Any, estimates: Any) -> Heard:
    ids = wire.ids(name, peers)
    wire.check(name, len(ids) <= MAX_PEERS, f"expects at most {MAX_PEERS} peers", len(ids))
    wire.check(name, type(counts) is list and len(counts) == 3, "expects heard, missed and concealed", counts)
    heard, missed, concealed = (_counts(name, blob, len(ids)) for blob in counts)
    is_long = type(estimates) is bytes and len(estimates) == 8 * len(ids)
    wire.check(name, is_long, f"expects {len(ids)} float64", estimates)
    of_peers = np.frombuffer(estimates, dtype="<f8")
    wire.check(name, not np.isinf(of_peers).any(), "numbers must be finite, or NaN", of_peers.tolist())
    return Heard(ids, heard, missed, concealed, of_peers)


def _counts(name: str, blob: Any, peers: int) -> Ints:
    wire.check(name, type(blob) is bytes and len(blob) == 8 * peers, f"expects {peers} int64", blob)
    values = np.frombuffer(blob, dtype="<i8").astype(np.int64)
    inside = bool(((values >= 0) & (values <= MAX_COUNT)).all())
    wire.check(name, inside, f"expects counts from 0 to {MAX_COUNT}", values.tolist())
    return values


def _between(name: str, value: Any, least: float, most: float, what: str) -> float:
    inside = type(value) is float and least <= value <= most  # NaN is not
    wire.check(name, inside, f"expects {what} from {least:g} to {most:g}", value)
    return float(value)
