"""Messages on the topics for viewers, made from a Report: frames, scenes, remarks and states.

Frames are after ROS REP 103 and 105: `map`, x to the east and z up, and `robot_3/base_link`, x forward.
"""

import math
from collections.abc import Iterator
from functools import cache

import numpy as np
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.LinePrimitive_pb2 import LinePrimitive
from foxglove_schemas_protobuf.Log_pb2 import Log
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from google.protobuf.timestamp_pb2 import Timestamp

from fes.arrays.types import Floats
from fes.model.sensing import Telemetry
from fes.protocol.report import Report
from fes.recording import messages_pb2
from fes.recording.messages_pb2 import LinkState, RobotState

MAP = "map"

INFO, WARNING = Log.INFO, Log.WARNING

_ORIGIN: dict[str, dict[str, float]] = {"position": {}, "orientation": {"w": 1.0}}
_BODY_COLOR = {"r": 0.25, "g": 0.6, "b": 1.0, "a": 1.0}
_SHADES = 15  # of the links' colors: few, because each distinct number takes bytes
_COLORS = [{"r": shade / _SHADES, "g": 1.0 - shade / _SHADES, "b": 0.2, "a": 1.0} for shade in range(_SHADES + 1)]
_ROBOT_FIELDS = tuple(field.name for field in RobotState.DESCRIPTOR.fields)
_LINK_FIELDS = tuple(field.name for field in LinkState.DESCRIPTOR.fields)


def timestamp(nanoseconds: int) -> Timestamp:
    """A simulated time [ns]."""
    return Timestamp(seconds=nanoseconds // 1_000_000_000, nanos=nanoseconds % 1_000_000_000)


def transforms(report: Report, time: Timestamp) -> FrameTransforms:
    """The pose of each robot's frame in the map."""
    message = FrameTransforms()
    half = 0.5 * report.poses[:, 2]
    columns = (report.poses[:, 0], report.poses[:, 1], np.sin(half), np.cos(half))
    for robot, (x, y, sine, cosine) in enumerate(np.column_stack(columns).tolist()):
        message.transforms.add(
            timestamp=time,
            parent_frame_id=MAP,
            child_frame_id=_frame(robot),
            translation={"x": x, "y": y},
            rotation={"z": sine, "w": cosine},
        )
    return message


def bodies(robots: int, time: Timestamp) -> SceneUpdate:
    """An arrow and a number for each robot in its own frame, so that one message is enough for a run."""
    message = SceneUpdate()
    for robot in range(robots):
        entity = message.entities.add(timestamp=time, frame_id=_frame(robot), id=f"robot {robot}", frame_locked=True)
        entity.arrows.add(
            pose=_ORIGIN,
            shaft_length=5.0,
            shaft_diameter=2.0,
            head_length=4.0,
            head_diameter=4.0,
            color=_BODY_COLOR,
        )
        entity.texts.add(
            pose={"position": {"z": 5.0}, **_ORIGIN},
            billboard=True,
            font_size=14.0,
            scale_invariant=True,
            color=_BODY_COLOR,
            text=str(robot),
        )
    return message


def links(report: Report, time: Timestamp) -> SceneUpdate:
    """The links in use: green where all beacons decode, red where none does."""
    ends = np.stack([report.a, report.b], axis=1).reshape(-1)
    shades = np.rint(np.nan_to_num(report.outage, nan=1.0) * _SHADES).astype(int).tolist()
    message = SceneUpdate()
    entity = message.entities.add(timestamp=time, frame_id=MAP, id="links")
    entity.lines.add(
        type=LinePrimitive.LINE_LIST,
        pose=_ORIGIN,
        thickness=2.0,
        scale_invariant=True,
        points=[{"x": x, "y": y} for x, y in report.poses[ends, :2].tolist()],
        colors=[_COLORS[shade] for shade in shades for _ in range(2)],
    )
    return message


def remark(time: Timestamp, level: "Log.Level.ValueType", text: str) -> Log:
    """One line of text."""
    return Log(timestamp=time, level=level, message=text, name="fes-world")


def team(report: Report, payload: bytes) -> messages_pb2.Report:
    """The Report itself, and its numbers for the team."""
    return messages_pb2.Report(
        tick=report.tick,
        payload=payload,
        optimal_separation=report.optimal_separation,
        mean_estimate_error=report.mean_estimate_error,
        disagreement=report.disagreement,
        estimate_error_max=report.estimate_error_max,
        separation_error_max=report.separation_error_max,
        links=len(report.a),
        beacons_sent=report.beacons_sent,
        beacons_decoded=report.beacons_decoded,
    )


def robots(report: Report, twists: Floats, telemetry: Telemetry) -> Iterator[RobotState]:
    """The state of each robot, in id order; `twists` [n, 2]."""
    counts = telemetry.links.counts
    totals = telemetry.links.sum(telemetry.estimates)
    means = np.divide(totals, counts, out=np.full(len(counts), math.nan), where=counts > 0)
    for row in np.column_stack([report.poses, twists, means, counts]).tolist():
        yield RobotState(**dict(zip(_ROBOT_FIELDS, row, strict=True)))


def pairs(report: Report) -> Iterator[tuple[int, int, LinkState]]:
    """Lower id, higher id and state of each link in use."""
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
    rows = np.column_stack(columns).tolist()
    for a, b, row in zip(report.a.tolist(), report.b.tolist(), rows, strict=True):
        yield a, b, LinkState(**dict(zip(_LINK_FIELDS, row, strict=True)))


@cache
def _frame(robot: int) -> str:
    return f"robot_{robot}/base_link"
