"""The beacons or the commands of a tick, checked or read in one call of the compiled core."""

import ctypes
from array import array
from collections.abc import Sequence
from ctypes import addressof, c_char_p, c_int64, c_void_p
from typing import Any

import numpy as np

from fes.arrays.types import Floats
from fes.protocol import wire
from fes.protocol.messages import Command
from world.simulation.core import compiled_world
from world.simulation.core.structures import Batch, Parts

_FREE = {-1: None, 0: False, 1: True}


class MessageReader:
    """Calls of the core for the messages of one tick, each from another robot of a team.

    A message that is unusual in any way is left to `fes.protocol.messages`, which knows the reason to reject it.
    """

    def __init__(self, library: ctypes.CDLL, robots: int) -> None:
        """`robots` is their number in the team."""
        # The calls are short. To release the interpreter's lock would let a thread of Zenoh in, and then wait for it.
        short = ctypes.PyDLL(None, handle=library._handle)
        self._beacons, self._commands = short.fes_world_beacons, short.fes_world_commands
        self._beacons.restype = self._commands.restype = c_int64
        self._beacons.argtypes = [c_void_p, c_char_p, c_void_p, c_void_p]
        self._commands.argtypes = [c_void_p, c_char_p, *[c_void_p] * 5]
        self._batch = Batch(version=wire.PROTOCOL, robots=robots)
        self._address = addressof(self._batch)
        self._make_room(robots)

    def are_beacons(self, tick: int, senders: Sequence[int], payloads: Sequence[bytes]) -> bool:
        """True if each payload is the sender's usual beacon of this tick, which every peer can read."""
        lengths, robots = array("q", map(len, payloads)), array("q", senders)
        self._batch.tick, self._batch.count = tick, len(payloads)
        addresses = lengths.buffer_info()[0], robots.buffer_info()[0]
        return bool(self._beacons(self._address, b"".join(payloads), *addresses))

    def commands(self, tick: int, senders: Sequence[int], payloads: Sequence[bytes]) -> list[Command] | None:
        """The commands of the senders for this tick; None if one of them is unusual."""
        data, count = b"".join(payloads), len(payloads)
        if count > len(self._parts):
            self._make_room(count)
        lengths, robots = array("q", map(len, payloads)), array("q", senders)
        self._batch.tick, self._batch.count = tick, count
        addresses = lengths.buffer_info()[0], robots.buffer_info()[0]
        numbers = np.empty(len(data) // 8 + 1)
        if not self._commands(self._address, data, *addresses, *self._room, numbers.ctypes.data):
            return None
        numbers.flags.writeable = False
        rows = zip(senders, self._twists[:count].tolist(), self._parts[:count].tolist(), strict=True)
        return _split(tick, data, rows, numbers)

    def _make_room(self, count: int) -> None:
        """Make room for what `count` commands hold."""
        self._twists, self._parts = np.empty((count, 2)), np.empty((count, len(Parts._fields_)), dtype=np.int64)
        self._room = self._twists.ctypes.data, self._parts.ctypes.data


def _split(tick: int, data: bytes, rows: Any, numbers: Floats) -> list[Command]:
    """Commands from rows of (sender, twist, parts). Their links lie in `data`; their `numbers` follow each other."""
    commands, begin = [], 0
    for robot, (linear, angular), (first_byte, length, estimates, learnt, details, is_free) in rows:
        first, second = begin + estimates, begin + estimates + learnt
        end = second + details
        links, twist = wire.ids("Command", data[first_byte : first_byte + length]), (linear, angular)
        lists = numbers[begin:first], numbers[first:second], numbers[second:end]
        commands.append(Command(tick, robot, twist, links, *lists, _FREE[is_free]))
        begin = end
    return commands


def of(robots: int) -> MessageReader | None:
    """The reader of a team of so many robots; None where Python reads each message."""
    library = compiled_world.load()
    return None if library is None else MessageReader(library, robots)
