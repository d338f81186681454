"""A crew whose tick is one call of the compiled core, from the bytes of its messages to those of its answers."""

from array import array
from collections.abc import Sequence
from ctypes import addressof
from typing import Any

import numpy as np
from numpy.typing import NDArray

from agents.control.transmitter import RobotPayloads
from agents.core.compiled_crew import CompiledCrew
from agents.core.structures import Input, Messages
from fes.arrays.types import Ints

NEW_RANGE, FAILED, TOO_LITTLE_ROOM = 4, -1, -2
"""Results of fes_agent_tick."""

ROOM = 32
"""Room for pairs at first; it doubles where the world's observations have more."""

LINKS = 128
"""Links of each sender for which there is room: a beacon with more of them is unusual, so that no peer can slow the
others down permanently."""


class ByteCrew:
    """The messages of one process, and the call that answers them."""

    def __init__(self, crew: CompiledCrew, version: int) -> None:
        """`version` is that of the protocol."""
        self._crew = crew
        self._ids = crew.crew.ids.tolist()
        self._messages, self._input = Messages(version=version), Input()
        self._addresses = addressof(self._messages), addressof(self._input)
        self._since: Ints | None = None
        self._room = ROOM
        self._senders = 0
        self.peers: frozenset[int] = frozenset()
        """The peers in range of any robot, at the last tick that was answered; one object while they are the same."""
        self._make_room(0)

    def step(
        self,
        tick: int,
        observations: Sequence[bytes],
        beacons: Sequence[bytes],
        since: Ints,
        is_model_free: bool | None,
    ) -> list[RobotPayloads] | None:
        """The answers to the observations of a tick, of the robots in their order.

        `beacons` are those of the tick before, one per sender, by ascending sender. None, and no change, where a
        message is unusual in any way: it must then be read by `fes.protocol.messages`. `since` [n] are the ticks from
        which the robots take part.
        """
        if len(beacons) > self._senders:
            self._make_room(len(beacons))
        messages, skew = self._messages, self._crew.skew(tick)
        self._input.tick, self._input.skew = tick, None if skew is None else skew.ctypes.data
        if since is not self._since:
            self._since, messages.since = since, since.ctypes.data
        messages.is_model_free = -1 if is_model_free is None else is_model_free
        lengths, heard_lengths = array("q", map(len, observations)), array("q", map(len, beacons))
        messages.observation_lengths, messages.beacon_lengths = (
            lengths.buffer_info()[0],
            heard_lengths.buffer_info()[0],
        )
        messages.senders = len(beacons)
        sensed, heard = b"".join(observations), b"".join(beacons)
        flags = self._call(sensed, heard)
        while flags == TOO_LITTLE_ROOM:
            self._room *= 2
            self._make_room(self._senders)
            flags = self._call(sensed, heard)
        if flags < 0:
            return None
        if flags & NEW_RANGE:
            count = int(self._begin[len(self._ids)])
            self.peers = frozenset(self._in_range[:count].tolist())
        return self._answers()

    def _call(self, observations: bytes, beacons: bytes) -> int:
        return self._crew.step_bytes(*self._addresses, self._room, self._range_address, observations, beacons)

    def _answers(self) -> list[RobotPayloads]:
        """The payloads in the buffer."""
        ends, n = self._ends.tolist(), len(self._ids)
        out = bytes(self._written[: ends[-1]])
        parts = [out[begin:end] for begin, end in zip([0, *ends], ends, strict=False)]
        return list(zip(self._ids, parts[:n], parts[n:], strict=True))

    def _make_room(self, senders: int) -> None:
        """Let the messages point to arrays with room for all pairs, links and senders."""
        n, room, self._senders = len(self._ids), self._room, max(senders, self._senders, 8)
        count, q = self._senders, self._crew.statistics
        links = LINKS * count
        self._begin, self._in_range = np.zeros(n + 1, np.int64), np.zeros(room, np.int64)
        self._range = np.full(n + 1 + room, -1, np.int64)
        self._range_address: int = self._range.ctypes.data
        self._out, self._ends = np.zeros(n * (256 + 8 * q) + 64 * room, np.uint8), np.zeros(2 * n, np.int64)
        self._written = self._out.data
        arrays: dict[str, NDArray[Any]] = {
            "poses": np.zeros(3 * n),
            "begin": self._begin,
            "in_range": self._in_range,
            "reception": np.zeros(room, np.uint8),
            "sender_ids": np.zeros(count, np.int64),
            "link_begin": np.zeros(count + 1, np.int64),
            "link_peers": np.zeros(links, np.int64),
            "sender_poses": np.zeros(3 * count),
            "estimates": np.zeros(links),
            "statistics": np.zeros(count * q),
            "selected": np.zeros(links, np.uint8),
            "out": self._out,
            "ends": self._ends,
        }
        self._arrays = arrays
        self._messages.pairs, self._messages.links = room, links
        for name, values in arrays.items():
            setattr(self._messages, name, values.ctypes.data)
