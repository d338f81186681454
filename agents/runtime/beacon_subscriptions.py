"""The beacon subscriptions of a process: only to the peers in range of its robots."""

import asyncio
from collections.abc import Collection
from collections.abc import Set as AbstractSet

from fes.errors import MessageError, Overloaded, Rejected, Unavailable
from fes.protocol import keys, messages, packing
from fes.protocol.messages import Beacon
from fes.transport import bus
from fes.transport.bus import Bus, Mailbox
from fes.transport.drop_log import DropLog

RECALL_TIMEOUT = 2.0
"""Time [s] that a recall waits for the answer of the world. Then it is repeated."""


class BeaconSubscriptions:
    """One mailbox per peer in range."""

    def __init__(self, opened: Bus, run: str, robots: str, drops: DropLog) -> None:
        """`robots` are those of this process, written as by `fes.protocol.keys.span`."""
        self._bus = opened
        self._run, self._robots = run, robots
        self._drops = drops
        self._boxes: dict[int, Mailbox] = {}
        self._keys: dict[int, str] = {}
        """Key of each peer's beacons."""
        self._codes: dict[int, bytes] = {}
        """Id of each peer as it stands in its beacons."""
        self._early: dict[int, Beacon] = {}
        """Beacon of the tick after the last one read, by peer."""
        self._taken: dict[int, tuple[str, bytes | None]] = {}
        """Key and payload that were taken from the mailbox of a peer, and not read yet."""

    @property
    def peers(self) -> list[int]:
        """The peers to whose beacons this process is subscribed, ascending."""
        return list(self._boxes)

    def update(self, peers: AbstractSet[int]) -> None:
        """Subscribe to `peers`, and to no others.

        In lockstep the beacons of every later tick are received: peers step only after this robot's next command.
        """
        for peer in self._boxes.keys() - peers:
            self._boxes.pop(peer).close()
            del self._keys[peer], self._codes[peer]
            self._early.pop(peer, None)
            self._taken.pop(peer, None)
        for peer in peers - self._boxes.keys():
            key = self._keys[peer] = keys.beacon(self._run, peer)
            self._codes[peer] = packing.robot_code(peer)
            self._boxes[peer] = self._bus.mailbox(key)
        self._boxes = dict(sorted(self._boxes.items()))

    def heard(self, tick: int) -> list[Beacon]:
        """The beacons of `tick` that have arrived, ordered by sender; older ones are dropped."""
        heard = []
        for peer, box in self._boxes.items():
            early = self._early.pop(peer, None) if self._early else None
            beacon = early if early is not None and early.tick == tick else self._first(peer, box, tick)
            if beacon is not None:
                heard.append(beacon)
        return heard

    def payloads(self, tick: int) -> list[bytes]:
        """The payloads of the beacons of `tick` that have arrived, ordered by sender; unread but for their heads.

        Beacons that were taken from the mailboxes stay for `heard`, until `use` drops them.
        """
        head, payloads = packing.beacon_head(tick), []
        for peer, box in self._boxes.items():
            sample = self._taken.get(peer)
            if sample is None and peer not in self._early:
                sample = box.take()
                if sample is not None:
                    self._taken[peer] = sample
            if sample is None:
                continue
            key, payload = sample
            if payload is not None and key == self._keys[peer] and payload.startswith(head + self._codes[peer]):
                payloads.append(payload)
        return payloads

    def use(self, payloads: list[bytes]) -> None:
        """Drop these payloads, which `payloads` has returned: they were used."""
        if len(payloads) == len(self._taken):
            self._taken.clear()
        else:
            used = set(map(id, payloads))
            self._taken = {peer: sample for peer, sample in self._taken.items() if id(sample[1]) not in used}

    async def recall(self, tick: int, peers: Collection[int]) -> tuple[list[Beacon], bool]:
        """The beacons of `peers` from `tick` that the world resends, and True if it does not have one of them.

        Junk may have pushed a beacon out of its mailbox, or the beacon may have taken a slower path than the tick.
        The request goes to the world, not to the peer: even of a hostile sender all robots receive the same beacon.
        """
        answers = await asyncio.gather(*(self._held(peer, tick) for peer in peers))
        return [answer for answer in answers if isinstance(answer, Beacon)], False in answers

    async def _held(self, peer: int, tick: int) -> Beacon | bool:
        """The world's copy of a beacon; False if it has none, True if it cannot answer at the moment."""
        key = keys.held_beacon(self._run, peer, self._robots)
        try:
            payload = await self._bus.get(key, messages.encode_recall(tick), RECALL_TIMEOUT)
            beacon = messages.decode_beacon(payload)
        except (Unavailable, Overloaded):
            return True
        except (Rejected, MessageError):
            return False
        if (beacon.robot, beacon.tick) != (peer, tick):
            return False
        self._drops.reject(
            "Beacon: recalled", f"dropped from a full mailbox, or late: a beacon of robot {peer}; it was recalled"
        )
        return beacon

    def _first(self, peer: int, box: Mailbox, tick: int) -> Beacon | None:
        """The first beacon of `tick` in a box; what follows it stays there.

        The beacon of the next tick is stored, as that of `tick` may still follow it. Beacons beyond the next tick are
        dropped, as the world drops them too. At most a full box is read, since a sender may fill it while it is
        emptied.
        """
        for _ in range(bus.MAILBOX):
            sample = self._taken.pop(peer, None) or box.take()
            if sample is None:
                break
            beacon = self._read(peer, *sample)
            if beacon is None:
                continue
            if beacon.tick == tick:
                return beacon
            if beacon.tick == tick + 1:
                self._early.setdefault(peer, beacon)
            elif beacon.tick > tick:
                self._drops.reject("Beacon: from the future", f"a beacon of robot {peer} from tick {beacon.tick}")
        return None

    def _read(self, peer: int, key: str, payload: bytes | None) -> Beacon | None:
        try:
            if payload is None:
                raise MessageError("Beacon", "a deletion is not a beacon")
            beacon = messages.decode_beacon(payload)
            if beacon.robot != peer or key != self._keys[peer]:
                raise MessageError("Beacon", "came on another robot's key", key)
        except MessageError as error:
            self._drops.unread(key, error)
            return None
        return beacon
