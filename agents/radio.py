"""A process's ear: subscribed to the beacons of the peers in range of its robots, and to no others."""

from collections.abc import Collection

from fes import keys, messages
from fes.bus import Bus, Mailbox
from fes.complaints import Complaints
from fes.errors import Absent, MessageError, Refused
from fes.messages import Beacon

RECALL_TIMEOUT = 2.0
"""A world that does not repeat a beacon within this time [s] is asked again only if it was away."""


class Radio:
    """One mailbox for each peer in range."""

    def __init__(self, bus: Bus, run: str, complaints: Complaints) -> None:
        self._bus = bus
        self._run = run
        self._complaints = complaints
        self._boxes: dict[int, Mailbox] = {}
        self._early: dict[int, Beacon] = {}
        """A peer's beacon of a tick that this process has not reached yet: at most one a peer."""

    @property
    def tuned(self) -> list[int]:
        """The peers it listens to, ascending."""
        return list(self._boxes)

    def tune(self, peers: set[int]) -> None:
        """Listen to `peers` from now on. A beacon put after this, in tick order, will be heard."""
        for peer in self._boxes.keys() - peers:
            self._boxes.pop(peer).close()
            self._early.pop(peer, None)
        for peer in peers - self._boxes.keys():
            self._boxes[peer] = self._bus.mailbox(keys.beacon(self._run, peer))
        self._boxes = dict(sorted(self._boxes.items()))

    def heard(self, tick: int) -> list[Beacon]:
        """The beacons of `tick` that came, by sender; older ones are forgotten."""
        found = (self._beacon(peer, box, tick) for peer, box in self._boxes.items())
        return [beacon for beacon in found if beacon is not None]

    async def recall(self, tick: int, peers: Collection[int]) -> list[Beacon]:
        """The beacons of `peers` from `tick`, as far as the world has them, in any order.

        For beacons that junk pushed out of a mailbox, or that took a slower path than the tick. The world is asked,
        not the peer, so that all robots hear the same beacon, even from a hostile sender.
        """
        found = []
        for peer in peers:
            key = keys.held_beacon(self._run, peer)
            try:
                payload = await self._bus.ask(key, messages.encode_recall(tick), RECALL_TIMEOUT)
                beacon = messages.decode_beacon(payload)
            except (Absent, Refused, MessageError):
                continue  # the caller notices that it is missing
            if (beacon.robot, beacon.tick) == (peer, tick):
                found.append(beacon)
                self._complaints.add(
                    "Beacon: recalled", f"by a full mailbox, or late: a beacon of robot {peer}; asked for anew"
                )
        return found

    def _beacon(self, peer: int, box: Mailbox, tick: int) -> Beacon | None:
        early = self._early.pop(peer, None)
        if early is not None and early.tick == tick:
            return early
        while (sample := box.take()) is not None:
            beacon = self._read(peer, *sample)
            if beacon is not None and beacon.tick == tick:
                return beacon
            if beacon is not None and beacon.tick == tick + 1:
                self._early.setdefault(peer, beacon)
                continue
            if beacon is not None and beacon.tick > tick + 1:
                self._complaints.add("Beacon: from the future", f"a beacon of robot {peer} from tick {beacon.tick}")
        return None

    def _read(self, peer: int, key: str, payload: bytes | None) -> Beacon | None:
        try:
            if payload is None:
                raise MessageError("Beacon", "a deletion is not a beacon")
            beacon = messages.decode_beacon(payload)
            if beacon.robot != peer or keys.robot_of(key) != peer:
                raise MessageError("Beacon", "came on another robot's key", key)
        except MessageError as error:
            self._complaints.unread(key, error)
            return None
        return beacon
