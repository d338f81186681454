"""A process's ear: subscribed to the beacons of the peers in range of its robots, and to no others."""

from collections import deque
from collections.abc import Callable

from fes import keys, messages
from fes.bus import Bus
from fes.complaints import Complaints
from fes.errors import MessageError
from fes.messages import Beacon

MAX_WAITING = 100_000
"""Beacons that may wait to be read; what comes beyond is dropped."""


class Radio:
    """Subscriptions to peers' beacons, and the beacons that came, by tick."""

    def __init__(self, bus: Bus, run: str, complaints: Complaints) -> None:
        self._bus = bus
        self._run = run
        self._complaints = complaints
        self._tuned: dict[int, Callable[[], None]] = {}
        self._arrived: deque[tuple[str, bytes | None]] = deque(maxlen=MAX_WAITING)
        self._by_tick: dict[int, dict[int, Beacon]] = {}

    @property
    def tuned(self) -> set[int]:
        """The peers it listens to."""
        return set(self._tuned)

    def tune(self, peers: set[int]) -> None:
        """Listen to `peers` from now on. A beacon put after this, in tick order, will be heard."""
        for peer in self._tuned.keys() - peers:
            self._tuned.pop(peer)()
        for peer in sorted(peers - self._tuned.keys()):
            self._tuned[peer] = self._bus.subscribe(keys.beacon(self._run, peer), self._hand_over)

    def heard(self, tick: int) -> list[Beacon]:
        """The beacons of `tick` that came, by sender; forgets all older ones."""
        for _ in range(len(self._arrived)):
            self._read(*self._arrived.popleft())
        for old in [other for other in self._by_tick if other < tick]:
            del self._by_tick[old]
        found = self._by_tick.pop(tick, {})
        return [found[robot] for robot in sorted(found)]

    def _hand_over(self, key: str, payload: bytes | None) -> None:
        self._arrived.append((key, payload))

    def _read(self, key: str, payload: bytes | None) -> None:
        try:
            if payload is None:
                raise MessageError("Beacon", "a deletion is not a beacon")
            beacon = messages.decode_beacon(payload)
            if keys.robot_of(key) != beacon.robot:
                raise MessageError("Beacon", "came on another robot's key", key)
        except MessageError as error:
            self._complaints.add(f"{error.schema}: {error.rule}", f"{key}: {error}")
            return
        self._by_tick.setdefault(beacon.tick, {}).setdefault(beacon.robot, beacon)
