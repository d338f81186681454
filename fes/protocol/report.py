"""Report: world to observers, several times per second. It holds the truth, and the telemetry of the robots.

No agent subscribes to it. Quantities that do not exist yet (such as an estimate of a robot without links) are NaN.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from fes.arrays.types import Bytes, Floats, Ints
from fes.protocol import wire

_LINK_ARRAYS = (
    "separation",
    "estimate_ab",
    "estimate_ba",
    "outage",
    "sent",
    "decoded",
    "longest_gap",
    "learnt_reception",
    "learnt_level",
    "learnt_exponent",
)
_NUMBERS = (
    "dt",
    "optimal_separation",
    "elapsed",
    "ticks_per_s",
    "disagreement",
    "estimate_error_max",
    "separation_error_max",
    "true_level",
    "true_exponent",
    "mean_estimate_error",
    "changed_at",
    "tracking_time",
)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Report:
    """The state of the team at one tick."""

    scenario: str
    tick: int
    ticks: int
    """Total number of ticks of the run."""
    dt: float
    """Tick length [s]."""
    optimal_separation: float
    """r* of the true channel and objective [m]."""
    elapsed: float
    """Wall-clock time since tick 0 [s]."""
    ticks_per_s: float
    """Recent rate [1/s]."""
    alive: Bytes
    """1 for each robot that takes part, and whose agent is alive [n]."""
    poses: Floats
    """True poses [n, 3] [m, m, rad; world frame]."""
    a: Ints
    """Links in use: the lower id [l]."""
    b: Ints
    """The higher id [l]."""
    separation: Floats
    """True separation [l] [m]."""
    estimate_ab: Floats
    """Estimate of robot a [l] [m]."""
    estimate_ba: Floats
    """Estimate of robot b [l] [m]."""
    outage: Floats
    """True outage probability of a beacon, both ways averaged [l]."""
    sent: Floats
    """Beacons sent since the contact opened, both ways together [l]."""
    decoded: Floats
    """Those of them that decoded [l]."""
    longest_gap: Floats
    """Most beacons lost in a row since the contact opened, of both ways [l]."""
    learnt_reception: Floats
    """Reception at this separation as the robots estimate it from their counts [l]; NaN if they do not."""
    learnt_level: Floats
    """alpha of their fit ln(-ln p) = alpha + nu ln(r / rho_0), mean of both ends [l]."""
    learnt_exponent: Floats
    """nu of the same fit, mean of both ends [l]."""
    beacons_sent: int
    beacons_decoded: int
    disagreement: float
    """Sum over links of the two estimates' difference [m]."""
    estimate_error_max: float
    """Largest |estimate - r*| [m]."""
    separation_error_max: float
    """Largest |separation - r*| over links [m]."""
    true_level: float
    """alpha of the true channel's formula at rho_0."""
    true_exponent: float
    """nu of the true channel's formula at rho_0."""
    mean_estimate_error: float
    """Mean estimate less r* [m]."""
    changed_at: float
    """Time of the last change of the channel, or of the start [s]."""
    tracking_time: float
    """Time from the change until the mean estimate stays within 1 m of r* [s]; NaN until then."""
    missed: Ints
    """Deadlines of the live clock that each robot missed [n]; [0] in lockstep."""
    late: Ints
    """Commands of each robot that arrived after their deadline [n]; [0] in lockstep."""
    disk_connected: bool
    """True if the graph of all robots in range is connected."""


def encode_report(report: Report) -> bytes:
    """The payload of a Report."""
    return wire.pack(
        report.scenario,
        report.tick,
        report.ticks,
        [getattr(report, name) for name in _NUMBERS],
        report.alive.tobytes(),
        report.poses.tobytes(),
        report.a.astype("<i4").tobytes(),
        report.b.astype("<i4").tobytes(),
        [getattr(report, name).tobytes() for name in _LINK_ARRAYS],
        report.beacons_sent,
        report.beacons_decoded,
        report.disk_connected,
        [report.missed.astype("<i8").tobytes(), report.late.astype("<i8").tobytes()],
    )


def decode_report(payload: bytes) -> Report:
    """The Report in a payload; raises MessageError."""
    name = "Report"
    fields = wire.unpack(name, payload, 13)
    scenario, tick, ticks, numbers, alive, poses, a, b, arrays, sent, decoded, connected, deadlines = fields
    wire.check(name, type(deadlines) is list and len(deadlines) == 2, "expects missed and late", deadlines)
    wire.check(name, type(scenario) is str, "expects the scenario's name", scenario)
    wire.check(name, type(numbers) is list and len(numbers) == len(_NUMBERS), "expects numbers", numbers)
    wire.check(name, all(type(value) is float for value in numbers), "expects numbers", numbers)
    wire.check(name, type(alive) is bytes, "expects one code per robot", alive)
    robots = len(alive)
    wire.check(name, type(arrays) is list and len(arrays) == len(_LINK_ARRAYS), "expects link arrays", arrays)
    lower, higher = _ids(name, a, robots), _ids(name, b, robots)
    wire.check(name, len(lower) == len(higher), "expects two ends per link", len(higher))
    links: dict[str, Any] = {
        key: _floats(name, blob, len(lower)) for key, blob in zip(_LINK_ARRAYS, arrays, strict=True)
    }
    return Report(
        scenario=scenario,
        tick=wire.tick(name, tick),
        ticks=wire.tick(name, ticks),
        **dict(zip(_NUMBERS, numbers, strict=True)),
        alive=wire.codes(name, alive, robots, 1),
        poses=wire.numbers(name, poses, 3 * robots).reshape(robots, 3),
        a=lower,
        b=higher,
        **links,
        beacons_sent=wire.tick(name, sent),
        beacons_decoded=wire.tick(name, decoded),
        missed=_counts(name, deadlines[0], robots),
        late=_counts(name, deadlines[1], robots),
        disk_connected=wire.flag(name, connected),
    )


def _ids(name: str, blob: Any, robots: int) -> Ints:
    wire.check(name, type(blob) is bytes and len(blob) % 4 == 0, "expects ids as int32", blob)
    ids = np.frombuffer(blob, dtype="<i4").astype(np.int64)
    inside = bool(((ids >= 0) & (ids < robots)).all())  # a viewer looks up both ends of a link
    wire.check(name, inside, f"expects links between its {robots} robots", ids.tolist())
    return ids


def _counts(name: str, blob: Any, robots: int) -> Ints:
    """Counts of all robots [n], or of none [0]."""
    fits = type(blob) is bytes and len(blob) in (0, 8 * robots)
    wire.check(name, fits, f"expects {robots} int64, or none", blob)
    return np.frombuffer(blob, dtype="<i8").astype(np.int64)


def _floats(name: str, blob: Any, count: int) -> Floats:
    """Numbers [count]; NaN stands for one that does not exist."""
    wire.check(name, type(blob) is bytes and len(blob) == 8 * count, f"expects {count} float64", blob)
    return np.frombuffer(blob, dtype="<f8")
