"""Frames between the agent and its gate, over a stream socket of this machine, and both of its ends.

Each direction has frames of one size, little-endian. Times are nanoseconds of CLOCK_MONOTONIC, which both processes
share. Neither end ever waits for the other: a frame for which the socket has no room is dropped. So a frozen agent
does not hold up the gate, and a frozen gate does not hold up the agent.

| frame    | direction     | contents                                                              |
|----------|---------------|-----------------------------------------------------------------------|
| Command  | agent -> gate | sequence, computed at, linear, angular, heard at                      |
| PoseSeen | gate -> agent | received at, stamp, x, y, heading, linear, angular                    |
| Progress | gate -> agent | mode, accepted, refused, linear, angular, length of the reason, reason |
"""

import contextlib
import socket
import struct
from typing import NamedTuple

from fes.errors import MessageError
from fes.protocol.robot_control import MODES, GateStatus

_COMMAND = struct.Struct("<B7xQqddq")
_POSE = struct.Struct("<B7xqq5d")
_PROGRESS = struct.Struct("<BB6xQQddH")

TO_GATE = _COMMAND.size
"""Size of a frame to the gate [bytes]."""

TO_AGENT = 160
"""Size of a frame to the agent [bytes]."""

LONGEST_REASON = TO_AGENT - _PROGRESS.size
"""Longest reason in a frame [bytes]; a longer one is cut."""

A_COMMAND, A_POSE, A_PROGRESS = 1, 2, 3
"""First byte of a frame."""

ROOM = 16384
"""Room of the socket in each direction [bytes]."""

CHUNK = 65536
"""Most bytes that are read at once."""


class Command(NamedTuple):
    """A command from the agent, in the law's units."""

    sequence: int
    computed_at: int
    """Begin of the tick that it answers [ns]: no input is newer."""
    linear: float
    """[m/s; full size]"""
    angular: float
    """[rad/s]"""
    heard_at: int
    """Time at which the robot heard a peer last [ns]; 0 before the first."""


class PoseSeen(NamedTuple):
    """A pose of the body."""

    received_at: int
    """Time of its arrival [ns]."""
    stamp: int
    """Time on the clock of the driver [ns]; 0 if it has none."""
    pose: tuple[float, float, float]
    """x, y, heading [m, m, rad; team frame, full size]."""
    twist: tuple[float, float]
    """Twist that the driver measured [m/s, rad/s; full size]; NaN if there is none."""


class Progress(NamedTuple):
    """The state of the gate, without the pose."""

    mode: str
    """RUNNING, STOPPED or HELD."""
    reason: str
    """Why it is not running; empty while it is."""
    accepted: int
    refused: int
    twist: tuple[float, float]
    """The twist that it commands now [m/s, rad/s; full size]."""


def pair() -> tuple[socket.socket, socket.socket]:
    """The agent's end and the gate's end of a new link, which neither wait nor queue much."""
    ends = socket.socketpair()
    for end in ends:
        end.setblocking(False)
        end.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, ROOM)
    return ends


def encode_command(command: Command) -> bytes:
    """The frame of a Command."""
    return _COMMAND.pack(A_COMMAND, *command)


def decode_command(frame: bytes) -> Command:
    """The Command in a frame; raises MessageError. Its numbers may be of any kind, NaN too."""
    kind, *fields = _COMMAND.unpack(frame)
    if kind != A_COMMAND:
        raise MessageError("Command", "expects a frame of kind 1, got", str(kind))
    return Command(*fields)


def encode_pose(seen: PoseSeen) -> bytes:
    """The frame of a PoseSeen."""
    return _POSE.pack(A_POSE, seen.received_at, seen.stamp, *seen.pose, *seen.twist).ljust(TO_AGENT, b"\0")


def encode_progress(status: GateStatus) -> bytes:
    """The frame of a gate's state."""
    reason = status.reason.encode()[:LONGEST_REASON]
    counts = status.accepted, status.refused
    head = _PROGRESS.pack(A_PROGRESS, MODES.index(status.mode), *counts, *status.twist, len(reason))
    return (head + reason).ljust(TO_AGENT, b"\0")


def decode_to_agent(frame: bytes) -> PoseSeen | Progress:
    """The PoseSeen or Progress in a frame; raises MessageError."""
    if frame[0] == A_POSE:
        _, received_at, stamp, x, y, heading, linear, angular = _POSE.unpack_from(frame)
        return PoseSeen(received_at, stamp, (x, y, heading), (linear, angular))
    _, mode, accepted, refused, linear, angular, length = _PROGRESS.unpack_from(frame)
    if frame[0] != A_PROGRESS or mode >= len(MODES) or length > LONGEST_REASON:
        raise MessageError("Progress", "expects a frame of kind 2 or 3, a mode and a reason, got", frame[:2].hex())
    reason = frame[_PROGRESS.size : _PROGRESS.size + length].decode(errors="ignore")
    return Progress(MODES[mode], reason, accepted, refused, (linear, angular))


class FrameSocket:
    """An end of a link: whole frames go in and out, and nothing waits."""

    def __init__(self, end: socket.socket, size: int) -> None:
        end.setblocking(False)
        self.end = end
        self.is_closed = False
        """True when the process at the far end has closed the link, or is dead."""
        self.dropped = 0
        """Frames for which the socket had no room."""
        self._size = size
        self._received = bytearray()
        self._rest = b""

    def send(self, frame: bytes) -> bool:
        """Send a frame; False if there is no room for it, or nothing at the far end."""
        self._rest = self._rest[self._written(self._rest) :]  # of a frame that was sent in part
        sent = 0 if self._rest else self._written(frame)
        if not sent:
            self.dropped += 1
            return False
        self._rest = frame[sent:]
        return True

    def receive(self) -> list[bytes]:
        """The whole frames that have arrived, of CHUNK bytes at most."""
        try:
            data = self.end.recv(CHUNK)
        except (BlockingIOError, InterruptedError):
            return []
        except OSError:
            data = b""
        self.is_closed = self.is_closed or not data
        self._received += data
        length = len(self._received) // self._size * self._size
        complete = bytes(self._received[:length])
        del self._received[:length]
        return [complete[first : first + self._size] for first in range(0, length, self._size)]

    def close(self) -> None:
        """Close this end: the far end sees it."""
        self.is_closed = True
        with contextlib.suppress(OSError):
            self.end.close()

    def _written(self, data: bytes) -> int:
        """The number of bytes that the socket takes."""
        try:
            return self.end.send(data) if data else 0
        except (BlockingIOError, InterruptedError):
            return 0
        except OSError:
            self.is_closed = True
            return 0
