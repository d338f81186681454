"""A process's mouth: beacons to peers, commands to the world, and either again when it is asked for."""

from collections.abc import Callable

from fes.errors import MessageError
from fes.protocol import keys, messages
from fes.transport.bus import Bus, Query
from fes.transport.drop_log import DropLog

Put = Callable[[bytes], None]

REMEMBERED = 2
"""Ticks whose beacons can be recalled: who misses one asks within the next tick, as the barrier waits for it."""


class Outbox:
    """What the robots of a process say."""

    def __init__(self, bus: Bus, run: str, robots: tuple[int, ...], drops: DropLog, mark: bytes = b"") -> None:
        """`mark` is that of the Join: the world takes commands from no other process of these robots."""
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

    def publish(self, tick: int, said: list[tuple[int, bytes, bytes]]) -> None:
        """Beacons first, commands last: the world's next tick then follows every beacon of this one."""
        # Remembered before they are put: a peer may ask as soon as one of them arrives.
        self._beacons[tick] = {robot: beacon for robot, beacon, _ in said}
        self._commands[tick] = {robot: command for robot, _, command in said}
        for told in (self._beacons, self._commands):
            for old in [known for known in told if known <= tick - REMEMBERED]:
                del told[old]
        for robot, beacon, _ in said:
            self._beacon[robot](beacon)
        for robot, _, command in said:
            self._command[robot](command)

    def has(self, tick: int) -> bool:
        """Whether this tick can be answered again."""
        return tick in self._commands

    def resend(self, tick: int, robot: int) -> None:
        """Answer a tick again that is remembered, as the world asked for it again."""
        self._beacon[robot](self._beacons[tick][robot])
        self._command[robot](self._commands[tick][robot])

    def _listen(self, bus: Bus, key: str, robot: int) -> None:
        """Tell a beacon again to who asks for it by its tick."""

        def on_question(query: Query) -> None:
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

        bus.declare_queryable(key, on_question)
