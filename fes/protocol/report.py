"""Report: world to observers, several times per second. It holds the truth, and the telemetry of the robots.

No agent subscribes to it. Quantities that do not exist yet (such as an estimate of a robot without links) are NaN.
Its last field is about the team index. Without it, a Report is byte for byte that of fes 0.5.
"""

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from fes.arrays.types import Bytes, Floats, Ints
from fes.protocol import wire

LINK_ARRAYS = (
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
"""The numbers of each link, in the order of the fields of a LinkState in a log."""

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
_TEAM_NUMBERS = ("team_index", "team_index_target", "delivery_after_loss")


def _none() -> Ints:
    return np.zeros(0, dtype=np.int64)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Report:
    """The state of the team at one tick."""

    scenario: str
    tick: int
    ticks: int
    """Total number of ticks of the run; 0 for real robots, whose run has no end."""
    dt: float
    """Tick length [s]."""
    optimal_separation: float
    """r* of the true channel and objective [m]; of a configuration, the best link length of its shape."""
    elapsed: float
    """Wall-clock time since tick 0 [s]."""
    ticks_per_s: float
    """Recent rate [1/s]."""
    alive: Bytes
    """1 for each robot that takes part, and whose agent is alive [n]."""
    poses: Floats
    """True poses [n, 3] [m, m, rad; world frame]; of real robots what each believes, NaN before its first pose."""
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
    has_team_index: bool = False
    """True if the world computes the team index; without it the fields below have their defaults."""
    team_index: float = math.nan
    """Team index F [1]."""
    team_index_target: float = math.nan
    """F of the shape that the team takes up, at its r_beta [1]."""
    delivery_after_loss: float = math.nan
    """Geometric mean over pairs of the quality of their best route, after the worst loss [1]."""
    cutting: Ints = field(default_factory=_none)
    """Robots whose loss would cut the links in use, ascending [k]."""
    slots: Ints = field(default_factory=_none)
    """Slot of each robot in the shape, -1 without one [n]; [0] if no configuration is sought."""
    plans: Ints = field(default_factory=_none)
    """Kind of plan of each robot [n]: 0 a direct plan, 1 a contraction, 2 none; [0] if no configuration is sought."""

    @property
    def is_of_robots(self) -> bool:
        """True if it merges the reports of real robots, without a world that knows the truth."""
        return self.ticks == 0


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
        [getattr(report, name).tobytes() for name in LINK_ARRAYS],
        report.beacons_sent,
        report.beacons_decoded,
        report.disk_connected,
        [report.missed.astype("<i8").tobytes(), report.late.astype("<i8").tobytes()],
        *([_encode_team(report)] if report.has_team_index else []),
    )


def decode_report(payload: bytes) -> Report:
    """The Report in a payload; raises MessageError."""
    name = "Report"
    fields = wire.unpack(name, payload, 13, optional=1)
    scenario, tick, ticks, numbers, alive, poses, a, b, arrays, sent, decoded, connected, deadlines = fields[:13]
    wire.check(name, type(deadlines) is list and len(deadlines) == 2, "expects missed and late", deadlines)
    wire.check(name, type(scenario) is str, "expects the scenario's name", scenario)
    wire.check(name, type(numbers) is list and len(numbers) == len(_NUMBERS), "expects numbers", numbers)
    wire.check(name, all(type(value) is float for value in numbers), "expects numbers", numbers)
    wire.check(name, type(alive) is bytes, "expects one code per robot", alive)
    robots = len(alive)
    wire.check(name, type(arrays) is list and len(arrays) == len(LINK_ARRAYS), "expects link arrays", arrays)
    lower, higher = _ids(name, a, robots), _ids(name, b, robots)
    wire.check(name, len(lower) == len(higher), "expects two ends per link", len(higher))
    links: dict[str, Any] = {
        key: _floats(name, blob, len(lower)) for key, blob in zip(LINK_ARRAYS, arrays, strict=True)
    }
    return Report(
        scenario=scenario,
        tick=wire.tick(name, tick),
        ticks=wire.tick(name, ticks),
        **dict(zip(_NUMBERS, numbers, strict=True)),
        alive=wire.codes(name, alive, robots, 1),
        poses=(_floats if ticks == 0 else wire.numbers)(name, poses, 3 * robots).reshape(robots, 3),
        a=lower,
        b=higher,
        **links,
        beacons_sent=wire.tick(name, sent),
        beacons_decoded=wire.tick(name, decoded),
        missed=_counts(name, deadlines[0], robots),
        late=_counts(name, deadlines[1], robots),
        disk_connected=wire.flag(name, connected),
        **(_decode_team(name, fields[13], robots) if len(fields) > 13 else {}),
    )


def _encode_team(report: Report) -> list[Any]:
    numbers = [float(getattr(report, name)) for name in _TEAM_NUMBERS]
    return [numbers, *(ids.astype("<i4").tobytes() for ids in (report.cutting, report.slots, report.plans))]


def _decode_team(name: str, team: Any, robots: int) -> dict[str, Any]:
    """The fields about the team index."""
    wire.check(name, type(team) is list and len(team) == 4, "expects four parts of the team index", team)
    numbers, cutting, slots, plans = team
    fits = type(numbers) is list and len(numbers) == len(_TEAM_NUMBERS)
    wire.check(name, fits and all(type(value) is float for value in numbers), "expects numbers", numbers)
    return {
        "has_team_index": True,
        **dict(zip(_TEAM_NUMBERS, numbers, strict=True)),
        "cutting": _ids(name, cutting, robots),
        "slots": _codes(name, slots, robots, -1, robots - 1),
        "plans": _codes(name, plans, robots, 0, 2),
    }


def _codes(name: str, blob: Any, robots: int, lowest: int, highest: int) -> Ints:
    """Small numbers of all robots [n], or of none [0]."""
    wire.check(name, type(blob) is bytes and len(blob) in (0, 4 * robots), f"expects {robots} int32, or none", blob)
    values = np.frombuffer(blob, dtype="<i4").astype(np.int64)
    inside = bool(((values >= lowest) & (values <= highest)).all())
    wire.check(name, inside, f"expects numbers from {lowest} to {highest}", values.tolist())
    return values


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
