"""The outbox of a process: beacons to peers, commands to the world, and retransmission of both on request."""

from collections.abc import Callable

from fes.errors import MessageError
from fes.protocol import keys, messages
from fes.transport.bus import Bus, Query
from fes.transport.drop_log import DropLog

Put = Callable[[bytes], None]

REMEMBERED = 2
"""Ticks whose beacons can be recalled: the barrier waits for a missed beacon, so its request comes within a tick."""


class Outbox:
    """The publishers of a process's robots, and its latest payloads."""

    def __init__(self, bus: Bus, run: str, robots: tuple[int, ...], drops: DropLog, mark: bytes = b"") -> None:
        """`mark` is that of the Join: the world accepts commands from no other process of these robots."""
        self._drops = drops
        self._beacon: dict[int, Put] = {}
        self._command: dict[int, Put] = {}
        self._commands: dict[int, dict[int, bytes]] = {}
        self._beacons: dict[int, dict[int, bytes]] = {}
        """Both by tick, then by robot."""
        for robot in robots:
            self._beacon[robot] = bus.declare_publisher(keys.beacon(run, robot), "fes.Beacon")
            self._command[robot] = bus.declare_publisher(keys.command(run, robot), "fes.Command", mark=mark)
            self._listen(bus, keys.recall(run, robot), robot)

    def publish(self, tick: int, payloads: list[tuple[int, bytes, bytes]]) -> None:
        """Publish the beacons, then the commands: the world's next tick then follows every beacon of this one."""
        # Stored before they are published: a peer may ask as soon as the first of them arrives.
        self._beacons[tick] = {robot: beacon for robot, beacon, _ in payloads}
        self._commands[tick] = {robot: command for robot, _, command in payloads}
        for stored in (self._beacons, self._commands):
            for old in [known for known in stored if known <= tick - REMEMBERED]:
                del stored[old]
        for robot, beacon, _ in payloads:
            self._beacon[robot](beacon)
        for robot, _, command in payloads:
            self._command[robot](command)

    def has(self, tick: int) -> bool:
        """True if the payloads of this tick are still stored."""
        return tick in self._commands

    def resend(self, tick: int, robot: int) -> None:
        """Publish the payloads of a stored tick again, at the world's request."""
        self._beacon[robot](self._beacons[tick][robot])
        self._command[robot](self._commands[tick][robot])

    def _listen(self, bus: Bus, key: str, robot: int) -> None:
        """Reply to recall queries with the beacon of their tick."""

        def on_query(query: Query) -> None:
            try:
                tick = messages.decode_recall(query.payload)
            except MessageError as error:
                self._drops.unread(key, error)
                query.reply_err(str(error))
                return
            if tick not in self._beacons:
                query.reply_err(f"robot {robot} does not remember its beacon of tick {tick}")
                return
            query.reply(self._beacons[tick][robot], "fes.Beacon")

        bus.declare_queryable(key, on_query)
