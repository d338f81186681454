"""The log and the summary of real robots, as an observer saw them.

The log has the topics for viewers of a run's log, and no messages of its ticks: nothing is deterministic, so there is
no digest. Each robot's own log holds its decisions.
"""

import math
import time
from collections.abc import Callable
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from console.measures import belief
from console.team.merge import Team
from fes.arrays.types import Floats
from fes.errors import FesError
from fes.protocol.report import LINK_ARRAYS, Report, encode_report
from fes.protocol.world_info import version
from fes.recording.writer import frames
from fes.recording.writer.connection import LogWriter
from fes.recording.writer.frames import BODIES, INFO, REMARK, REPORT
from fes.system import strict_json
from world.execution.recorder import MAX_VIEWED
from world.metrics import summary

if TYPE_CHECKING:
    from fes.recording.writer.log_file import LogFile

NAME = "team.mcap"
"""Name of the log in its directory: it is not that of a run, which could be replayed."""

MAX_SEQUENCE = 2**32 - 1
"""Largest number of a message in a log."""


class TeamRecorder:
    """Context that writes team.mcap and summary.json into a directory; raises FesError if it cannot."""

    def __init__(
        self, directory: Path, team: Team, writer: "Callable[[Path], LogWriter | LogFile]" = LogWriter
    ) -> None:
        """The directory is created; one that is not empty is refused."""
        directory.mkdir(parents=True, exist_ok=True)
        if any(directory.iterdir()):
            raise FesError(f"--record {directory}: the directory is not empty")
        self._directory, self._team = directory, team
        self._log = writer(directory / NAME)
        self._bodies = self._reports = 0
        self._begun = time.time()
        self._last: Report | None = None
        self._alive: Report | None = None
        self._smallest = math.inf

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        table = self.summary()
        summary.write(self._directory, table)
        loss = self._log.finish({"ended": "the observer left", "summary": strict_json.dumps(table)})
        if loss is not None and error is None:
            raise FesError(f"{self._directory / NAME} {loss} meanwhile: the log is incomplete")

    def add(self, report: Report) -> None:
        """Add a merged Report."""
        messages: list[list[Any]] = []
        if self._last is None:
            messages.append([REMARK, INFO, f"real robots of {report.scenario}, as their reports tell"])
        n, is_viewed = len(report.alive), len(report.alive) <= MAX_VIEWED
        if n > self._bodies and is_viewed:
            messages.append([BODIES, n])
            self._bodies = n
        arrays = self._arrays(report) if is_viewed else None
        messages.append([REPORT, encode_report(report), frames.numbers(report), arrays])
        self._log.write(min(report.tick, MAX_SEQUENCE), round(report.elapsed * 1e9), messages)
        self._last, self._reports = report, self._reports + 1
        if report.alive.any():
            self._alive = report
        known = report.separation[np.isfinite(report.separation)]
        self._smallest = min(self._smallest, float(known.min(initial=math.inf)))

    def summary(self) -> dict[str, Any]:
        """The numbers that are known without the truth; None for one that is not known.

        They are those of the last report with a robot alive: often the robots leave before the observer.
        """
        report = self._alive
        head = {"clock": summary.ROBOTS, "fes": version(), "begun": self._begun, "ended": time.time()}
        if report is None:
            return {**head, "robots": 0, "reports": 0}
        mean = belief.mean_estimate(report)
        disagreement, spread, formation = belief.series(report).tolist()
        table = {
            **head,
            "scenario": report.scenario,
            "robots": len(self._team.members),
            "reports": self._reports,
            "dt": report.dt,
            "elapsed_s": report.elapsed,
            "mean_estimate": mean,
            "estimate_spread": spread,
            "disagreement": disagreement,
            "formation_error_max": formation,
            "separation_rms_about_mean_estimate": _rms(report.separation - mean),
            "smallest_separation_of_links": self._smallest,
            "heard_connected": report.disk_connected,
            "links": _links(report),
            "beacons": dict(self._team.totals()),
            "members": self._members(report),
        }
        finite: dict[str, Any] = strict_json.finite(table)
        return finite

    def _members(self, report: Report) -> list[dict[str, Any]]:
        return [
            {
                "robot": robot,
                "alive": bool(report.alive[robot]),
                "starts": member.starts,
                "elapsed_s": member.report.elapsed,
                "pose": list(member.report.pose) if member.report.has_pose else None,
                "gate": member.report.mode,
                "reason": member.report.reason,
                "model_free": member.report.command.is_model_free,
                "links": member.report.command.links.tolist(),
                **member.totals(),
            }
            for robot, member in sorted(self._team.members.items())
        ]

    def _arrays(self, report: Report) -> list[bytes]:
        """The arrays that viewers see, for `fes.recording.viewer_topics.View.of`."""
        n = len(report.alive)
        twists, counts, totals = np.full((n, 2), math.nan), np.zeros(n), np.zeros(n)
        for robot, member in self._team.members.items():
            if robot < n and report.alive[robot]:
                command = member.report.command
                twists[robot] = command.twist
                counts[robot], totals[robot] = len(command.links), command.estimates.sum()
        ids = [ends.astype(np.int64).tobytes() for ends in (report.a, report.b)]
        states = b"".join([getattr(report, name).tobytes() for name in LINK_ARRAYS])
        return [*(array.tobytes() for array in (report.poses, twists, counts, totals)), *ids, states]


def _links(report: Report) -> list[dict[str, Any]]:
    names = ("separation", "estimate_ab", "estimate_ba", "sent", "decoded")
    columns = [getattr(report, name).tolist() for name in names]
    ends = zip(report.a.tolist(), report.b.tolist(), *columns, strict=True)
    return [dict(zip(("a", "b", *names), row, strict=True)) for row in ends]


def _rms(values: Floats) -> float:
    known = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(known * known))) if len(known) else math.nan
