"""Frames between a run and the writer of its log: a length, and a msgpack array of that length.

A frame of the run is [request, method, arguments]; `fes.recording.writer.log_file` has the methods. Request 0 wants
no answer. An answer is [request, result], or [FAILED, text] once the writer cannot continue.

All messages of a tick are one frame. So an interrupted run, or a killed one, leaves whole ticks.
"""

import struct
from collections.abc import Iterator
from typing import Any

import msgpack
import numpy as np

from fes.arrays.types import Floats
from fes.model.sensing import Telemetry
from fes.protocol.report import LINK_ARRAYS, Report

SCENARIO, BODIES, PAYLOADS, EVENT, REMARK, REPORT = "scenario", "bodies", "payloads", "event", "remark", "report"
PACKED = "packed"
"""Kinds of messages: [SCENARIO, JSON], [BODIES, robots], [PAYLOADS, observations, beacons, commands], [PACKED, data,
ends], [EVENT, JSON], [REMARK, level, text], [REPORT, payload, numbers, arrays for viewers or None]."""

ROBOT, STEP, ROBOT_EVENT = "robot", "step", "robot event"
"""Kinds of messages of a robot's log: [ROBOT, JSON, level, text], [STEP, arguments of `robot_log.topics.step`],
[ROBOT_EVENT, JSON, level, text]. The texts are remarks for viewers."""

INFO, WARNING = 2, 3
"""Levels of a remark, as `foxglove.Log` numbers them."""

_OF_THE_TEAM = (
    "optimal_separation",
    "mean_estimate_error",
    "disagreement",
    "estimate_error_max",
    "separation_error_max",
    "beacons_sent",
    "beacons_decoded",
)

_LENGTH = struct.Struct("<Q")
_PACKER = msgpack.Packer()  # it holds the interpreter's lock while it packs; a new one takes 10 us

FAILED = -1
"""Request of an answer that states why the writer ends."""


def pack(*fields: Any) -> bytes:
    """A frame of numbers, text, bytes, None, and lists of them.

    >>> list(Splitter().feed(pack(0, "write", [b"x"])))
    [[0, 'write', [b'x']]]
    """
    packed: bytes = _PACKER.pack(fields)
    return _LENGTH.pack(len(packed)) + packed


class Splitter:
    """The frames in a stream of bytes that arrives in pieces."""

    def __init__(self) -> None:
        self._waiting = bytearray()

    def feed(self, piece: bytes) -> Iterator[list[Any]]:
        """The frames that are complete with the next piece of the stream."""
        self._waiting += piece
        place = 0
        try:
            while len(self._waiting) - place >= _LENGTH.size:
                (length,) = _LENGTH.unpack_from(self._waiting, place)
                end = place + _LENGTH.size + length
                if end > len(self._waiting):
                    break
                with memoryview(self._waiting) as view:
                    frame = msgpack.unpackb(view[place + _LENGTH.size : end])
                place = end
                yield frame
        finally:
            del self._waiting[:place]


def numbers(report: Report) -> dict[str, Any]:
    """The numbers of a Report for the team, by their names in `fes.Report` of the log."""
    return {name: getattr(report, name) for name in _OF_THE_TEAM} | {"links": len(report.a)}


def arrays(report: Report, twists: Floats, telemetry: Telemetry) -> list[bytes]:
    """The arrays that viewers see, for `fes.recording.viewer_topics.View.of`; `twists` [n, 2]."""
    links = telemetry.links
    floats = [report.poses, twists, links.counts.astype(np.float64), links.sum(telemetry.estimates)]
    states = b"".join([getattr(report, name).tobytes() for name in LINK_ARRAYS])
    ids = [report.a.astype(np.int64), report.b.astype(np.int64)]
    return [array.tobytes() for array in (*floats, *ids)] + [states]
