"""The outbox of a process: beacons to peers, commands to the world, and retransmission of both on request."""

from collections.abc import Callable

from fes.errors import MessageError
from fes.protocol import keys, messages
from fes.transport.bus import Bus, Query
from fes.transport.drop_log import DropLog

Put = Callable[[bytes], None]

REMEMBERED = 2
"""Number of ticks whose payloads are stored. The barrier waits for a lost beacon, so its recall comes in time."""


class Outbox:
    """The publishers of a process's robots, and their latest payloads."""

    def __init__(self, bus: Bus, run: str, robots: tuple[int, ...], drops: DropLog, mark: bytes = b"") -> None:
        """`mark` is that of the Join: the world accepts commands of these robots only with this mark."""
        self._drops = drops
        self._beacon: dict[int, Put] = {}
        self._command: dict[int, Put] = {}
        self._commands: dict[int, dict[int, bytes]] = {}
        self._beacons: dict[int, dict[int, bytes]] = {}
        """Both dictionaries: tick -> robot -> payload."""
        for robot in robots:
            self._beacon[robot] = bus.declare_publisher(keys.beacon(run, robot), "fes.Beacon")
            self._command[robot] = bus.declare_publisher(keys.command(run, robot), "fes.Command", mark=mark)
            self._serve_recalls(bus, keys.recall(run, robot), robot)

    def publish(self, tick: int, payloads: list[tuple[int, bytes, bytes]]) -> None:
        """Publish the beacons, then the commands: so every beacon of this tick precedes the world's next tick."""
        # Stored first: the world may recall a beacon as soon as another one arrives.
        self._beacons[tick] = {robot: beacon for robot, beacon, _ in payloads}
        self._commands[tick] = {robot: command for robot, _, command in payloads}
        for stored in (self._beacons, self._commands):
            while (oldest := next(iter(stored))) <= tick - REMEMBERED:
                del stored[oldest]
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

    def _serve_recalls(self, bus: Bus, key: str, robot: int) -> None:
        """Reply to each recall with the robot's beacon of the requested tick."""

        def on_query(query: Query) -> None:
            try:
                tick = messages.decode_recall(query.payload)
            except MessageError as error:
                self._drops.unread(key, error)
                query.reply_err(str(error))
                return
            beacon = self._beacons.get(tick, {}).get(robot)  # the thread of the ticks may delete it meanwhile
            if beacon is None:
                query.reply_err(f"robot {robot} does not remember its beacon of tick {tick}")
                return
            query.reply(beacon, "fes.Beacon")

        bus.declare_queryable(key, on_query)
