"""An Observation per tick from the beacons that a robot's radio has heard.

A robot of a simulated world is told which peers are in range, and which of their beacons decoded. A real robot
derives both from its radio. A peer is in range while it has been heard within the last `memory` ticks. `Verdicts`
states for each tick whether a beacon of the peer decoded; the tick then gets the newest beacon. No contact is CLOSED.

Robots step at times of their own. A beacon's pose is from the sender's step, and the crew relates it to its own pose
at the tick before. The two differ by up to a tick, so a separation has an error of the relative velocity times this
time: with 20 ms and 2 m/s up to 4 cm, of either sign. `poses_at_reception` has the own poses without this error, for
a law that needs them.
"""

import numpy as np

from fes.arrays.types import Ints
from fes.model.sensing import DECODED, LOST
from fes.protocol.messages import Beacon, Observation
from fes.protocol.sealed import Sealed
from field.senses.beacon_counts import BeaconCounts
from field.senses.own_poses import OwnPoses, Pose
from field.senses.peer import Heard, Peer

STALE = 4
"""A beacon is handed over until it is older than this part of the memory, but for a tick at least: the pose of a
silent peer is not true for long, and a contact must end in time."""


class Senses:
    """The beacons that one robot has heard of its peers."""

    def __init__(self, robot: int, memory: int) -> None:
        """`memory` is the number of ticks for which a silent peer counts as in range."""
        self.counts: dict[int, BeaconCounts] = {}
        """Counts of each peer that was ever heard."""
        self.foreign = 0
        """Beacons whose payload names another robot than their datagram, or this one."""
        self._robot, self._memory = robot, memory
        self._peers: dict[int, Peer] = {}
        self._poses = OwnPoses()
        self._stepped = -1
        self._since: int | None = None
        self._in_range: Ints = np.zeros(0, dtype=np.int64)
        self._taken: list[Heard] = []

    def hear(self, sealed: Sealed, beacon: Beacon, time: float) -> None:
        """Hold a beacon that arrived in a datagram; `beacon` is the datagram's payload.

        `time` is that of its arrival [own ticks]: the own step of tick k is due at k.
        """
        peer = beacon.robot
        if peer != sealed.robot or peer == self._robot:
            self.foreign += 1
            return
        heard, known = Heard(beacon, time), self._peers.get(peer)
        if known is None or known.boot != sealed.boot or time - known.last_heard > self._memory:
            counts = self.counts.setdefault(peer, BeaconCounts())
            self._peers[peer] = Peer(sealed, heard, counts)
        else:
            known.hear(sealed, heard)

    def step(self, tick: int, pose: Pose, fixed: int, since: int) -> tuple[Observation, list[Beacon]]:
        """The observation of a tick, and the newest beacons, which get the number of the tick before, by sender.

        `pose` is the own pose at this step, `fixed` the tick at which it was measured, and `since` the tick from
        which the robot takes part: with a new one all peers begin anew, since it did not listen before. Ticks ascend,
        and may skip some. Raises ValueError for one that does not ascend.
        """
        if tick <= self._stepped:
            raise ValueError(f"ticks must ascend, got {tick} after {self._stepped}")
        self._stepped = tick
        if self._since not in (None, since):
            self._peers.clear()
        self._since = since
        self._poses.add(tick, pose)
        in_range = self._peers_in_range(tick)
        longest_age = max(1, self._memory // STALE)
        taken = [self._peers[peer].take(tick, longest_age) for peer in in_range]
        reception = np.array([LOST if heard is None else DECODED for heard in taken], dtype=np.uint8)
        self._taken = [heard for heard in taken if heard is not None]
        beacons = [heard.beacon._replace(tick=tick - 1) for heard in self._taken]
        peers = self._as_array(in_range)
        return Observation(tick, self._robot, pose, peers, reception, over=False, since=since, fixed=fixed), beacons

    def poses_at_reception(self) -> list[Pose]:
        """Own pose at the arrival of each beacon that the last step returned, interpolated between own steps."""
        return [self._poses.between(heard.time) for heard in self._taken]

    def _peers_in_range(self, tick: int) -> list[int]:
        """The peers heard within memory, ascending, that have a verdict at `tick`; forget the silent ones."""
        for silent in [robot for robot, peer in self._peers.items() if tick - peer.last_heard > self._memory]:
            del self._peers[silent]
        return sorted(robot for robot, peer in self._peers.items() if peer.begin < tick)

    def _as_array(self, in_range: list[int]) -> Ints:
        """The peers as an array, the same one while they are the same: the crew then need not look them up."""
        if in_range != self._in_range.tolist():
            self._in_range = np.array(in_range, dtype=np.int64)
        return self._in_range


def arrival(arrived: int, epoch: int, dt: float) -> float:
    """Time [own ticks] of an arrival [ns], if tick 0 was due at the `epoch` [ns] and a tick takes `dt` [s]."""
    return (arrived - epoch) / (dt * 1e9)
