"""What viewers of a log show of one Report: poses, links, states; the message types are in fes/recording/schemas.py.

Frames are after ROS REP 103 and 105: `map`, x to the east and z up, and `robot_3/base_link`, x forward.
"""

import math
from collections.abc import Iterator
from functools import cache

import numpy as np

from fes.arrays.types import Floats
from fes.model.sensing import Telemetry
from fes.protocol.report import Report
from fes.recording.schemas import FOXGLOVE, OWN, TIMESTAMP

MAP = "map"

INFO, WARNING = 2, 3
"""Levels of a foxglove.Log."""

_LINE_LIST = 2
_HERE = {"position": (0.0, 0.0, 0.0), "orientation": (0.0, 0.0, 0.0, 1.0)}
_BODY = (0.25, 0.6, 1.0, 1.0)
_SHADES = 15  # of the links' colors: few, as each new number costs its bytes
_COLORS = [FOXGLOVE["Color"].encode((bad / _SHADES, 1.0 - bad / _SHADES, 0.2, 1.0)) for bad in range(_SHADES + 1)]
_LINE = {"type": _LINE_LIST, "pose": FOXGLOVE["Pose"].encode(_HERE), "thickness": 2.0, "scale_invariant": True}


def time(nanoseconds: int) -> bytes:
    """A simulated time as a Timestamp."""
    return TIMESTAMP.encode({"seconds": nanoseconds // 1_000_000_000, "nanos": nanoseconds % 1_000_000_000})


def transforms(report: Report, at: bytes) -> bytes:
    """foxglove.FrameTransforms: where each robot's frame is in the map."""
    places, ticks = np.zeros((len(report.poses), 3)), np.zeros((len(report.poses), 4))
    places[:, :2] = report.poses[:, :2]
    half = 0.5 * report.poses[:, 2]
    ticks[:, 2], ticks[:, 3] = np.sin(half), np.cos(half)
    rows = zip(FOXGLOVE["Vector3"].encode_rows(places), FOXGLOVE["Quaternion"].encode_rows(ticks), strict=True)
    return FOXGLOVE["FrameTransforms"].encode(
        {
            "transforms": [
                {
                    "timestamp": at,
                    "parent_frame_id": MAP,
                    "child_frame_id": _frame(robot),
                    "translation": place,
                    "rotation": turn,
                }
                for robot, (place, turn) in enumerate(rows)
            ]
        }
    )


def bodies(robots: int, at: bytes) -> bytes:
    """foxglove.SceneUpdate: an arrow and a number for each robot, in its own frame, so that once is enough."""
    arrow = {"shaft_length": 5.0, "shaft_diameter": 2.0, "head_length": 4.0, "head_diameter": 4.0}
    above = {"position": (0.0, 0.0, 5.0), "orientation": (0.0, 0.0, 0.0, 1.0)}
    label = {"pose": above, "billboard": True, "font_size": 14.0, "scale_invariant": True, "color": _BODY}
    return FOXGLOVE["SceneUpdate"].encode(
        {
            "entities": [
                {
                    "timestamp": at,
                    "frame_id": _frame(robot),
                    "id": f"robot {robot}",
                    "frame_locked": True,
                    "arrows": [{"pose": _HERE, **arrow, "color": _BODY}],
                    "texts": [{**label, "text": str(robot)}],
                }
                for robot in range(robots)
            ]
        }
    )


def links(report: Report, at: bytes) -> bytes:
    """foxglove.SceneUpdate: the links in use, green where all beacons decode and red where none does."""
    points = np.zeros((len(report.a), 2, 3))
    points[:, 0, :2], points[:, 1, :2] = report.poses[report.a, :2], report.poses[report.b, :2]
    bad = np.rint(np.nan_to_num(report.outage, nan=1.0) * _SHADES).astype(int).tolist()
    drawn = {
        **_LINE,
        "points": FOXGLOVE["Point3"].encode_rows(points.reshape(-1, 3)),
        "colors": [_COLORS[shade] for shade in bad for _ in range(2)],
    }
    entity = {"timestamp": at, "frame_id": MAP, "id": "links", "lines": [drawn]}
    return FOXGLOVE["SceneUpdate"].encode({"entities": [entity]})


def remark(at: bytes, level: int, text: str) -> bytes:
    """foxglove.Log: one line."""
    return FOXGLOVE["Log"].encode({"timestamp": at, "level": level, "message": text, "name": "fes-world"})


def team(report: Report, payload: bytes) -> bytes:
    """fes.Report: the Report itself, and its numbers for the team."""
    return OWN["Report"].encode(
        {
            "tick": report.tick,
            "payload": payload,
            "optimal_separation": report.optimal_separation,
            "mean_estimate_error": report.mean_estimate_error,
            "disagreement": report.disagreement,
            "estimate_error_max": report.estimate_error_max,
            "separation_error_max": report.separation_error_max,
            "links": len(report.a),
            "beacons_sent": report.beacons_sent,
            "beacons_decoded": report.beacons_decoded,
        }
    )


def robots(report: Report, twists: Floats, said: Telemetry) -> list[bytes]:
    """fes.RobotState of each robot, in id order; `twists` [n, 2]."""
    counts = said.links.counts
    metrics = said.links.sum(said.estimates)
    mean = np.divide(metrics, counts, out=np.full(len(counts), math.nan), where=counts > 0)
    return OWN["RobotState"].encode_rows(np.column_stack([report.poses, twists, mean, counts]))


def pairs(report: Report) -> Iterator[tuple[int, int, bytes]]:
    """Lower id, higher id and fes.LinkState of each link in use."""
    columns = (
        report.separation,
        report.estimate_ab,
        report.estimate_ba,
        report.outage,
        report.sent,
        report.decoded,
        report.longest_gap,
        report.learnt_reception,
        report.learnt_level,
        report.learnt_exponent,
    )
    states = OWN["LinkState"].encode_rows(np.column_stack(columns))
    return zip(report.a.tolist(), report.b.tolist(), states, strict=True)


@cache
def _frame(robot: int) -> str:
    return f"robot_{robot}/base_link"
