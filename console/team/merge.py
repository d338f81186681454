"""The latest RobotReports of the robots of a team, merged into one Report.

There is no truth: separations are those of the robots' own poses, and all that only a world knows is NaN. Time is
passed in as `now`, a monotonic time of the observer [s].
"""

import math
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from fes.arrays.types import Bools, Ints
from fes.protocol.keys import MAX_ROBOTS
from fes.protocol.report import Report
from fes.protocol.robot_report import RobotReport
from fes.protocol.wire import MAX_TICK
from world.metrics import graphs

SILENT = 1.0
"""Time without a RobotReport after which a robot counts as dead [s]."""

RECENT = 2.0
"""Time without a new beacon after which a peer counts as out of range [s]."""

COUNTS = ("heard", "missed", "concealed")
"""Kinds of beacons that a robot counts."""

MAX_SUM = MAX_TICK - 1
"""Largest number of beacons in a Report."""

Pair = tuple[int, int]


@dataclass
class Member:
    """One robot, as far as the observer knows it."""

    report: RobotReport
    """Its latest report."""
    time: float
    """Its arrival [s]."""
    starts: int = 1
    """Starts of its agent that the observer has seen."""
    past: Counter[str] = field(default_factory=Counter)
    """Beacons heard, missed and concealed in the reports of its agent's earlier starts."""
    counted: dict[int, int] = field(default_factory=dict)
    """Beacons heard of each peer."""
    rose: dict[int, float] = field(default_factory=dict)
    """Peer -> time at which that number last rose [s]."""

    def add(self, report: RobotReport, now: float) -> None:
        """Replace its latest report."""
        if report.boot != self.report.boot:
            self.starts += 1
            self.past = self.totals()
            self.counted = {}
        for peer, heard in zip(report.beacons.peers.tolist(), report.beacons.heard.tolist(), strict=True):
            if heard > self.counted.get(peer, 0):
                self.rose[peer] = now
            self.counted[peer] = heard
        self.report, self.time = report, now

    def totals(self) -> Counter[str]:
        """Beacons heard, missed and concealed, of all peers and all starts together."""
        beacons = self.report.beacons
        return Counter({name: self.past[name] + int(getattr(beacons, name).sum()) for name in COUNTS})


class Team:
    """The robots of one run."""

    def __init__(self, name: str, robots: Iterable[int] = ()) -> None:
        """`robots` are ids that belong to the team, even if they are never seen."""
        self.name = name
        self.members: dict[int, Member] = {}
        self._ids = set(robots)
        self._zero = math.inf
        self._dt = math.nan

    @property
    def number(self) -> int:
        """Number of rows of a Report: the highest id and one."""
        return max(self._ids, default=-1) + 1

    def expect(self, robot: int) -> None:
        """Note that a robot belongs to the team, as one of its tokens shows."""
        if robot < MAX_ROBOTS:
            self._ids.add(robot)

    def add(self, report: RobotReport, now: float) -> bool:
        """Add a report that arrived at `now`; False if it is older than the latest one of its robot."""
        robot, known = report.robot, self.members.get(report.robot)
        if robot >= MAX_ROBOTS:
            return False
        if known is not None and report.boot == known.report.boot and report.elapsed <= known.report.elapsed:
            return False
        if known is None:
            known = self.members[robot] = Member(report, now)
        known.add(report, now)
        self._ids.add(robot)
        self._zero = min(self._zero, now - report.elapsed)
        self._dt = report.dt if math.isnan(self._dt) else self._dt
        return True

    def is_alive(self, robot: int, now: float) -> bool:
        """True if a robot has reported recently."""
        return robot in self.members and now - self.members[robot].time < SILENT

    def alive(self, now: float) -> list[int]:
        """The robots that have reported recently, ascending."""
        return [robot for robot in sorted(self.members) if self.is_alive(robot, now)]

    def modes(self, now: float) -> str:
        """The modes of the gates in words, such as '2 running, 1 stopped'."""
        living = (self.members[robot].report.mode or "without a gate" for robot in self.alive(now))
        return ", ".join(f"{count} {mode}" for mode, count in sorted(Counter(living).items()))

    def report(self, now: float) -> Report:
        """The Report at `now`, after the first report of a robot."""
        n, present = self.number, self.alive(now)
        alive = np.zeros(n, dtype=np.uint8)
        alive[present] = 1
        poses = np.full((n, 3), math.nan)
        for robot, member in self.members.items():
            if member.report.has_pose:
                poses[robot] = member.report.pose
        pairs = sorted(set(self._links(present)))
        a, b = np.array(pairs, dtype=np.int64).reshape(-1, 2).T
        places = np.clip(poses, -1e150, 1e150)  # a square does not overflow
        separation = np.hypot(places[a, 0] - places[b, 0], places[a, 1] - places[b, 1])
        estimates = np.array([self._estimates(*pair, now) for pair in pairs], dtype=np.float64).reshape(-1, 2)
        counts = np.array([self._counts(*pair) for pair in pairs], dtype=np.float64).reshape(-1, 2)
        differences = np.abs(estimates[:, 0] - estimates[:, 1])
        elapsed = now - self._zero
        unknown = np.full(len(pairs), math.nan)
        beacons = self.totals()
        return Report(
            scenario=self.name,
            tick=round(elapsed / self._dt),
            ticks=0,
            dt=self._dt,
            optimal_separation=math.nan,
            elapsed=elapsed,
            ticks_per_s=math.nan,
            alive=alive,
            poses=poses,
            a=a,
            b=b,
            separation=separation,
            estimate_ab=estimates[:, 0].copy(),
            estimate_ba=estimates[:, 1].copy(),
            outage=unknown,
            sent=counts[:, 0].copy(),
            decoded=counts[:, 1].copy(),
            longest_gap=unknown,
            **self._learnt(pairs, separation.tolist(), now),
            beacons_sent=min(beacons.total(), MAX_SUM),
            beacons_decoded=min(beacons["heard"], MAX_SUM),
            disagreement=float(differences[np.isfinite(differences)].sum()),
            estimate_error_max=math.nan,
            separation_error_max=math.nan,
            true_level=math.nan,
            true_exponent=math.nan,
            mean_estimate_error=math.nan,
            changed_at=0.0,
            tracking_time=math.nan,
            missed=np.zeros(0, dtype=np.int64),
            late=np.zeros(0, dtype=np.int64),
            disk_connected=graphs.parts(alive == 1, *self._heard(present, now)) <= 1,
        )

    def totals(self) -> Counter[str]:
        """Beacons heard, missed and concealed, of all robots and all their peers together."""
        counts = Counter(dict.fromkeys(COUNTS, 0))
        for member in self.members.values():
            counts.update(member.totals())
        return counts

    def _links(self, present: list[int]) -> Iterator[Pair]:
        """The links that a present robot uses, lower id first."""
        for robot in present:
            for peer in self.members[robot].report.command.links.tolist():
                if peer != robot and peer in self._ids:
                    yield min(robot, peer), max(robot, peer)

    def _heard(self, present: list[int], now: float) -> tuple[Ints, Ints]:
        """Pairs of present robots, one of which has recently heard the other."""
        pairs = [
            (robot, peer)
            for robot in present
            for peer, time in self.members[robot].rose.items()
            if now - time < RECENT and self.is_alive(peer, now)
        ]
        a, b = np.array(pairs, dtype=np.int64).reshape(-1, 2).T
        return a, b

    def _estimates(self, a: int, b: int, now: float) -> tuple[float, float]:
        """The estimates of both ends [m]; that of a silent robot is the last that its peer has heard."""
        return self._estimate(a, b, now), self._estimate(b, a, now)

    def _estimate(self, robot: int, peer: int, now: float) -> float:
        if self.is_alive(robot, now):
            command = self.members[robot].report.command
            return _of_peer(command.links, command.estimates, peer)
        beacons = self.members[peer].report.beacons
        return _of_peer(beacons.peers, beacons.estimates, robot)

    def _counts(self, a: int, b: int) -> Pair:
        """Beacons sent and decoded, both ways together."""
        sent = decoded = 0
        for robot, peer in ((a, b), (b, a)):
            if robot in self.members:
                peers, heard, missed, _, _ = self.members[robot].report.beacons
                for index in np.flatnonzero(peers == peer).tolist():
                    decoded += int(heard[index])
                    sent += int(heard[index] + missed[index])
        return sent, decoded

    def _learnt(self, pairs: list[Pair], separations: list[float], now: float) -> dict[str, Any]:
        """Level, exponent and reception of each link, as both ends have learnt them."""
        rows = np.full((3, len(pairs)), math.nan)
        for index, (pair, separation) in enumerate(zip(pairs, separations, strict=True)):
            ends = [
                line
                for robot, peer in (pair, pair[::-1])
                if self.is_alive(robot, now) and (line := _line(self.members[robot].report, peer)) is not None
            ]
            if ends:
                level, exponent, scale = np.mean(ends, axis=0).tolist()
                rows[:, index] = _reception(level, exponent, separation / scale), level, exponent
        return dict(zip(("learnt_reception", "learnt_level", "learnt_exponent"), rows.copy(), strict=True))


def _of_peer(peers: Ints, values: Any, peer: int) -> float:
    where: Bools = peers == peer
    return float(values[where][0]) if where.any() else math.nan


def _line(report: RobotReport, peer: int) -> tuple[float, float, float] | None:
    """Level, exponent and rho_0 [m] that a robot has learnt for the link to a peer; None if it learns none."""
    links, learnt = report.command.links, report.command.learnt
    where = np.flatnonzero(links == peer).tolist()
    if not where or report.reference_separation <= 0.0 or len(learnt) != 2 * len(links):
        return None
    level, exponent = learnt.reshape(2, -1)[:, where[0]].tolist()
    return level, exponent, report.reference_separation


@np.errstate(all="ignore")
def _reception(level: float, exponent: float, ratio: float) -> float:
    """p of ln(-ln p) = level + exponent ln(r / rho_0)."""
    return float(np.exp(-np.exp(level + exponent * np.log(np.float64(ratio)))))
