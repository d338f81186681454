"""Messages on the topics for viewers, made from the arrays of a Report: frames, scenes, remarks and states.

Frames are after ROS REP 103 and 105: `map`, x to the east and z up, and `robot_3/base_link`, x forward.
"""

import math
from collections.abc import Iterator
from functools import cache
from typing import Any, NamedTuple, Self

import numpy as np
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.LinePrimitive_pb2 import LinePrimitive
from foxglove_schemas_protobuf.Log_pb2 import Log
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from google.protobuf.message import Message
from google.protobuf.timestamp_pb2 import Timestamp

from fes.arrays.types import Floats, Ints
from fes.protocol.report import LINK_ARRAYS, Report
from fes.recording import messages_pb2
from fes.recording.messages_pb2 import LinkState, RobotState

MAP = "map"

_ORIGIN: dict[str, dict[str, float]] = {"position": {}, "orientation": {"w": 1.0}}
_BODY_COLOR = {"r": 0.25, "g": 0.6, "b": 1.0, "a": 1.0}
_SHADES = 15  # of the links' colors: few, because each distinct number takes bytes
_COLORS = [{"r": shade / _SHADES, "g": 1.0 - shade / _SHADES, "b": 0.2, "a": 1.0} for shade in range(_SHADES + 1)]
_ROBOT_FIELDS = tuple(field.name for field in RobotState.DESCRIPTOR.fields)
_LINK_FIELDS = tuple(field.name for field in LinkState.DESCRIPTOR.fields)
_OUTAGE, _SENT, _DECODED = (_LINK_FIELDS.index(name) for name in ("outage", "sent", "decoded"))


class Motion(NamedTuple):
    """The arrays of n robots that a Report lacks; a log has them."""

    twists: Floats
    """[n, 2] [m/s, rad/s]"""
    counts: Floats
    """Links of each robot [n]."""
    totals: Floats
    """Sum of the estimates of each robot, over its links [n] [m]."""


class View(NamedTuple):
    """The arrays that viewers see, of n robots and l links in use."""

    poses: Floats
    """True poses [n, 3] [m, m, rad; world frame]."""
    a: Ints
    """Links: the lower id [l]."""
    b: Ints
    """The higher id [l]."""
    states: Floats
    """Fields of a LinkState, in their order [10, l]."""
    motion: Motion | None = None
    """None for an observer of a running run, which knows the Report only."""

    @classmethod
    def of(cls, poses: bytes, twists: bytes, counts: bytes, totals: bytes, a: bytes, b: bytes, states: bytes) -> Self:
        """The view in the bytes of its arrays: int64 for ids, else float64."""
        lower, higher = np.frombuffer(a, dtype=np.int64), np.frombuffer(b, dtype=np.int64)
        motion = Motion(np.frombuffer(twists).reshape(-1, 2), np.frombuffer(counts), np.frombuffer(totals))
        states_ = np.frombuffer(states).reshape(len(_LINK_FIELDS), len(lower))
        return cls(np.frombuffer(poses).reshape(-1, 3), lower, higher, states_, motion)

    @classmethod
    def of_report(cls, report: Report) -> Self:
        """The view of an observer, from the Report alone."""
        return cls(report.poses, report.a, report.b, np.stack([getattr(report, name) for name in LINK_ARRAYS]))


def messages(
    tick: int, payload: bytes, numbers: dict[str, Any], view: View | None, time: Timestamp
) -> Iterator[tuple[str, Message]]:
    """Topics and messages about a Report, in the order of a log; without a view only the Report itself.

    `payload` is the Report as it was sent, `numbers` are those of `fes.recording.writer.frames.numbers`.
    """
    yield "/report", messages_pb2.Report(tick=tick, payload=payload, **numbers)
    if view is None:
        return
    yield "/tf", transforms(view, time)
    yield "/scene/links", links(view, time)
    if view.motion is not None:
        for robot, state in enumerate(robots(view.poses, view.motion)):
            yield f"/robot/{robot}/state", state
    for a, b, link in pairs(view):
        yield f"/link/{a}-{b}/state", link


def timestamp(nanoseconds: int) -> Timestamp:
    """A simulated time [ns]."""
    return Timestamp(seconds=nanoseconds // 1_000_000_000, nanos=nanoseconds % 1_000_000_000)


def transforms(view: View, time: Timestamp) -> FrameTransforms:
    """The pose of each robot's frame in the map; a robot whose pose is unknown has none."""
    message = FrameTransforms()
    half = 0.5 * view.poses[:, 2]
    columns = (view.poses[:, 0], view.poses[:, 1], np.sin(half), np.cos(half))
    known = [bool(row.all()) for row in np.isfinite(view.poses)]
    for robot, (x, y, sine, cosine) in enumerate(np.column_stack(columns).tolist()):
        if known[robot]:
            _place(message, robot, (x, y), (sine, cosine), time)
    return message


def transform(robot: int, pose: tuple[float, float, float], time: Timestamp) -> FrameTransforms:
    """The pose of one robot's frame in the map [m, m, rad]."""
    message, (x, y, heading) = FrameTransforms(), pose
    _place(message, robot, (x, y), (math.sin(0.5 * heading), math.cos(0.5 * heading)), time)
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


def links(view: View, time: Timestamp) -> SceneUpdate:
    """The links in use: green where all beacons decode, red where none does."""
    ends = np.stack([view.a, view.b], axis=1).reshape(-1)
    outage = view.states[_OUTAGE]
    with np.errstate(invalid="ignore", divide="ignore"):
        counted = 1.0 - view.states[_DECODED] / view.states[_SENT]
    lost = np.where(np.isnan(outage), counted, outage)  # the outage of real robots is unknown
    shades = np.rint(np.nan_to_num(lost, nan=1.0) * _SHADES).astype(int).tolist()
    message = SceneUpdate()
    entity = message.entities.add(timestamp=time, frame_id=MAP, id="links")
    entity.lines.add(
        type=LinePrimitive.LINE_LIST,
        pose=_ORIGIN,
        thickness=2.0,
        scale_invariant=True,
        points=[{"x": x, "y": y} for x, y in view.poses[ends, :2].tolist()],
        colors=[_COLORS[shade] for shade in shades for _ in range(2)],
    )
    return message


def remark(time: Timestamp, level: "Log.Level.ValueType", text: str, name: str = "fes-world") -> Log:
    """One line of text, by the program `name`."""
    return Log(timestamp=time, level=level, message=text, name=name)


def robots(poses: Floats, motion: Motion) -> Iterator[RobotState]:
    """The state of each robot, in id order; `poses` [n, 3] [m, m, rad; world frame]."""
    counts = motion.counts
    means = np.divide(motion.totals, counts, out=np.full(len(counts), math.nan), where=counts > 0)
    for row in np.column_stack([poses, motion.twists, means, counts]).tolist():
        yield RobotState(**dict(zip(_ROBOT_FIELDS, row, strict=True)))


def pairs(view: View) -> Iterator[tuple[int, int, LinkState]]:
    """Lower id, higher id and state of each link in use."""
    for a, b, row in zip(view.a.tolist(), view.b.tolist(), view.states.T.tolist(), strict=True):
        yield a, b, LinkState(**dict(zip(_LINK_FIELDS, row, strict=True)))


@cache
def _frame(robot: int) -> str:
    return f"robot_{robot}/base_link"


def _place(
    message: FrameTransforms, robot: int, place: tuple[float, float], turn: tuple[float, float], time: Timestamp
) -> None:
    """Add a robot's frame, at a place [m], turned by an angle: sine and cosine of its half."""
    message.transforms.add(
        timestamp=time,
        parent_frame_id=MAP,
        child_frame_id=_frame(robot),
        translation={"x": place[0], "y": place[1]},
        rotation={"z": turn[0], "w": turn[1]},
    )
