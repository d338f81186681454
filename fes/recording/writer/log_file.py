"""The log as its writer makes it: frames become messages, topics for viewers and chunks.

A run gives one frame per tick. A chunk is closed between two of them, and never divides a tick.
"""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from google.protobuf.message import Message

from fes.recording import messages_pb2, schemas, viewer_topics
from fes.recording.layout import SUMMARY, PackedPayloads
from fes.recording.mcap_file import McapFile
from fes.recording.robot_log import layout, topics
from fes.recording.viewer_topics import View
from fes.recording.writer.frames import (
    BODIES,
    EVENT,
    PACKED,
    PAYLOADS,
    REMARK,
    REPORT,
    ROBOT,
    ROBOT_EVENT,
    SCENARIO,
    STEP,
)

if TYPE_CHECKING:
    from foxglove_schemas_protobuf.Log_pb2 import Log

_OF_ALL = (
    ("/observations", messages_pb2.Observations),
    ("/beacons", messages_pb2.Beacons),
    ("/commands", messages_pb2.Commands),
)


class LogFile:
    """A log that is written in this process; raises FesError if it cannot be written."""

    def __init__(self, path: Path, fileno: int | None = None) -> None:
        """`fileno` is the number of the file if it is open already."""
        self._file = McapFile(path, fileno)
        self._tick = self._time = 0
        self._view = topics.View()
        self._put_kind: dict[str, Callable[..., None]] = {
            SCENARIO: self._scenario,
            BODIES: self._bodies,
            PAYLOADS: self._payloads,
            PACKED: self._packed,
            EVENT: self._event,
            REMARK: self._remark,
            REPORT: self._report,
            ROBOT: self._robot,
            STEP: self._step,
            ROBOT_EVENT: self._robot_event,
        }

    @property
    def fileno(self) -> int:
        """The number of the open file."""
        return self._file.fileno

    def write(self, tick: int, time: int, messages: list[Any]) -> None:
        """Add the messages of a tick at a simulated time [ns], in order; a header is a chunk."""
        self._tick, self._time = tick, time
        for kind, *content in messages:
            self._put_kind[kind](*content)
        self._file.settle(at_once=messages[0][0] in (SCENARIO, ROBOT))

    def offer(self, tick: int, time: int, messages: list[Any]) -> bool:
        """Add messages as `write` does; True, since a file in this process is never behind."""
        self.write(tick, time, messages)
        return True

    def settle(self) -> None:
        """Close the chunk if it is old enough."""
        self._file.settle()

    def position(self) -> tuple[int, str]:
        """Close the chunk; returns the size of the file [bytes], and the SHA-256 of all its bytes."""
        return self._file.close_chunk(), self._file.sha256

    def copy(self, path: Path, size: int) -> None:
        """Copy all messages in the first `size` bytes of another log."""
        self._file.copy(Path(path), size)

    def finish(self, ended: dict[str, str], patience: float = 0.0) -> str | None:
        """Close the file with its summary; returns damage by other programs, in words.

        A file in this process needs no `patience`.
        """
        self._file.finish(SUMMARY, ended)
        return self._file.loss

    def close(self) -> None:
        """Close the file without its end, if it is open."""
        self._file.close()

    def _scenario(self, text: bytes) -> None:
        self._file.put("/scenario", schemas.SCENARIO, text, self._time, self._tick)

    def _event(self, text: bytes) -> None:
        self._file.put("/events", schemas.EVENT, text, self._time, self._tick)

    def _remark(self, level: "Log.Level.ValueType", text: str) -> None:
        self._put("/log", viewer_topics.remark(viewer_topics.timestamp(self._time), level, text))

    def _bodies(self, robots: int) -> None:
        self._put("/scene/robots", viewer_topics.bodies(robots, viewer_topics.timestamp(self._time)))

    def _payloads(self, *payloads: list[bytes]) -> None:
        for (topic, message), of_robots in zip(_OF_ALL, payloads, strict=True):
            self._put(topic, message(tick=self._tick, payloads=of_robots))

    def _packed(self, data: bytes, ends: bytes) -> None:
        self._payloads(*PackedPayloads(data, ends).unpacked())

    def _report(self, payload: bytes, numbers: dict[str, Any], arrays: list[bytes] | None) -> None:
        view, time = None if arrays is None else View.of(*arrays), viewer_topics.timestamp(self._time)
        for topic, message in viewer_topics.messages(self._tick, payload, numbers, view, time):
            self._put(topic, message)

    def _robot(self, text: bytes, level: "Log.Level.ValueType", remark: str) -> None:
        self._file.put(layout.HEADER, layout.HEADER_SCHEMA, text, self._time, self._tick)
        self._remark_of_robot(level, remark)

    def _step(self, *step: Any) -> None:
        message = topics.step(*step)
        self._put(layout.STEPS, message)
        for topic, shown in self._view.of(message.observation, message.command, self._time):
            self._put(topic, shown)

    def _robot_event(self, text: bytes, level: "Log.Level.ValueType", remark: str) -> None:
        self._file.put(layout.EVENTS, layout.EVENT_SCHEMA, text, self._time, self._tick)
        self._remark_of_robot(level, remark)

    def _remark_of_robot(self, level: "Log.Level.ValueType", text: str) -> None:
        time = viewer_topics.timestamp(self._time)
        self._put("/log", viewer_topics.remark(time, level, text, name="fes-robot"))

    def _put(self, topic: str, message: Message) -> None:
        self._file.put(topic, type(message), message.SerializeToString(), self._time, self._tick)
