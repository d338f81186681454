"""The beacons or the commands of a tick, checked or read in one call of the compiled core."""

import ctypes
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
        short.fes_world_beacons.restype = short.fes_world_commands.restype = c_int64
        short.fes_world_beacons.argtypes = [c_void_p]
        short.fes_world_commands.argtypes = [c_void_p] * 4
        self._beacons, self._commands = short.fes_world_beacons, short.fes_world_commands
        self._batch = Batch(version=wire.PROTOCOL, robots=robots)
        self._address = addressof(self._batch)
        self._make_room(robots)

    def are_beacons(self, tick: int, senders: Sequence[int], payloads: Sequence[bytes]) -> bool:
        """True if each payload is the sender's usual beacon of this tick, which every peer can read."""
        held = self._fill(tick, senders, payloads)
        return bool(self._beacons(self._address)) and bool(held)

    def commands(self, tick: int, senders: Sequence[int], payloads: Sequence[bytes]) -> list[Command] | None:
        """The commands of the senders for this tick; None if one of them is unusual."""
        count = len(payloads)
        held = self._fill(tick, senders, payloads)
        if count > len(self._parts):
            self._make_room(count)
        numbers = np.empty(sum(map(len, payloads)) // 8 + 1)
        if not self._commands(self._address, *self._room, numbers.ctypes.data) or not held:
            return None
        numbers.flags.writeable = False
        rows = zip(senders, payloads, self._twists[:count].tolist(), self._parts[:count].tolist(), strict=True)
        return _split(tick, rows, numbers)

    def _make_room(self, count: int) -> None:
        """Make room for what `count` commands hold."""
        self._twists, self._parts = np.empty((count, 2)), np.empty((count, len(Parts._fields_)), dtype=np.int64)
        self._room = self._twists.ctypes.data, self._parts.ctypes.data

    def _fill(self, tick: int, senders: Sequence[int], payloads: Sequence[bytes]) -> tuple[Any, ...]:
        """Let the batch name these payloads; returns what must live until the core has read them."""
        count, batch = len(payloads), self._batch
        data, lengths = (c_char_p * count)(*payloads), (c_int64 * count)(*map(len, payloads))
        robots = (c_int64 * count)(*senders)
        batch.tick, batch.count = tick, count
        batch.payloads, batch.lengths, batch.senders = addressof(data), addressof(lengths), addressof(robots)
        return data, lengths, robots


def _split(tick: int, rows: Any, numbers: Floats) -> list[Command]:
    """Commands from rows of (sender, payload, twist, parts), whose `numbers` follow each other."""
    commands, begin = [], 0
    for robot, payload, (linear, angular), (at, length, estimates, learnt, details, is_free) in rows:
        first, second = begin + estimates, begin + estimates + learnt
        end = second + details
        links, twist = wire.ids("Command", payload[at : at + length]), (linear, angular)
        lists = numbers[begin:first], numbers[first:second], numbers[second:end]
        commands.append(Command(tick, robot, twist, links, *lists, _FREE[is_free]))
        begin = end
    return commands


def of(robots: int) -> MessageReader | None:
    """The reader of a team of so many robots; None where Python reads each message."""
    library = compiled_world.load()
    return None if library is None else MessageReader(library, robots)
