"""The messages of a tick of a compiled crew that arrays move, written by one call of the core.

Twins: agents/runtime/marshalling.py, and world/execution/marshalling.py for the observations.
"""

import ctypes
from typing import NamedTuple

import numpy as np

from agents.core.compiled_crew import CompiledCrew
from agents.core.structures import Messages
from fes.arrays.types import Bools, Ints


class Written(NamedTuple):
    """Messages, one after the other: the observations of all robots, their beacons, their commands."""

    data: bytes
    ends: bytes
    """The end of each message, as int64 [3 n]."""


class PayloadWriter:
    """The places for the messages of a crew, and the call that writes them."""

    def __init__(self, crew: CompiledCrew, version: int) -> None:
        """`version` is that of the protocol."""
        n = len(crew.crew.ids)
        self._crew = crew
        self._ends = np.zeros(3 * n, np.int64)
        self._messages = Messages(version=version, ends=self._ends.ctypes.data)
        self._address = ctypes.addressof(self._messages)
        self._room = -1
        self._out = ctypes.create_string_buffer(1)
        self._since: Ints | None = None
        self._marks: tuple[Bools, Bools] | None = None
        self._mark_addresses = 0, 0

    def write(self, since: Ints, present: Bools, decodable: Bools, is_model_free: bool | None) -> Written:
        """The messages of the last tick; each array is [n], contiguous, and never changed in place.

        `since` are the ticks from which the robots take part. A robot that is not `present` has no observation and no
        command, and one that is not `decodable` no beacon: these are empty.
        """
        messages, marks = self._messages, self._marks
        if self._crew.stored.layout.capacity > self._room:
            self._make_room(self._crew.stored.layout.capacity)
        if since is not self._since:
            self._since, messages.since = since, since.ctypes.data
        if marks is None or present is not marks[0] or decodable is not marks[1]:
            self._marks, self._mark_addresses = (present, decodable), (present.ctypes.data, decodable.ctypes.data)
        messages.is_model_free = -1 if is_model_free is None else is_model_free
        length = self._crew.write(self._address, *self._mark_addresses)
        return Written(ctypes.string_at(self._out, length), self._ends.tobytes())

    def _make_room(self, capacity: int) -> None:
        """Let the messages point to room for a state of `capacity` contacts: 180 bytes per robot, 46 per contact."""
        n, q = len(self._crew.crew.ids), self._crew.statistics
        self._room = 2 * capacity
        self._out = ctypes.create_string_buffer(n * (256 + 8 * q) + 64 * self._room)
        self._messages.out = ctypes.addressof(self._out)
