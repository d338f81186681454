"""The world's own copy of each Beacon, by which it judges the robot that sent it.

A robot puts Beacon k before Command k on one first-in first-out link. So when the commands of tick k have
arrived, a missing or unreadable Beacon k is the fault of its sender alone. An accusation by a peer excludes no robot.
"""

import asyncio
import time
from collections.abc import Mapping

import numpy as np

from fes.arrays.types import Bools
from fes.errors import MessageError, Overloaded, Rejected, Unavailable
from fes.protocol import keys, messages
from fes.protocol.messages import Beacon
from fes.transport.bus import Bus, Query
from fes.transport.drop_log import DropLog, shown
from world.simulation.core import message_reader

RECALL_TIMEOUT = 2.0
"""A robot that does not repeat its beacon within this time [s] is at fault."""

RETRY = 0.05
"""Time between two queries to a robot that cannot answer at the moment [s]."""

Faults = dict[int, str]
"""Robot -> what is wrong with its beacon."""


class BeaconTap:
    """One mailbox per robot, and the beacons of the current tick."""

    def __init__(
        self,
        bus: Bus,
        run: str,
        robots: int,
        drops: DropLog,
        judged: Mapping[int, list[bytes]],
        guarded: bool = False,
    ) -> None:
        """`judged` maps past ticks to the beacons that peers may ask for; its owner keeps it up to date.

        `guarded` is True if access control lets only the robot itself publish on its key: all messages there are its
        own.
        """
        self._judged, self._guarded, self._robots = judged, guarded, robots
        self._bus, self._run, self._drops = bus, run, drops
        self._reader = message_reader.of(robots)
        self._mailboxes = [bus.mailbox(keys.beacon(run, robot)) for robot in range(robots)]
        self._payloads: dict[int, dict[int, bytes]] = {}
        """Tick -> robot -> its first readable payload; three ticks at most are stored."""
        self._faults: dict[int, Faults] = {}
        """Tick -> robot -> the rule that it broke."""
        bus.declare_queryable(keys.held_beacon(run, "*", "*"), self._on_recall)

    def received(self, tick: int, decodable: Bools) -> list[bytes]:
        """The payload of each robot's Beacon of `tick`, in id order; missing ones are counted.

        The payload of a robot is empty if it is not `decodable` [n], or if no readable beacon of it arrived.
        """
        payloads = self._collect(tick, decodable)
        for robot in np.flatnonzero(decodable).tolist():
            if not payloads[robot]:
                self._drops.note_missing("beacons in the log", f"no beacon of robot {robot} arrived for tick {tick}")
        return payloads

    def _collect(self, tick: int, decodable: Bools) -> list[bytes]:
        heard = decodable.tolist()
        arrived = {robot: self._mailboxes[robot].payloads() for robot, is_heard in enumerate(heard) if is_heard}
        if not self._take(tick, arrived):
            for robot, samples in arrived.items():
                self._sort(robot, tick, samples)
        for old in [known for known in self._payloads if known < tick - 1]:
            del self._payloads[old]
            self._faults.pop(old, None)
        payloads = self._payloads.get(tick, {})
        return [payloads.get(robot, b"") if is_heard else b"" for robot, is_heard in enumerate(heard)]

    def _take(self, tick: int, arrived: Mapping[int, list[bytes | None]]) -> bool:
        """Store one beacon of `tick` per robot, if the core finds nothing else; False if nothing was stored."""
        if self._reader is None or tick in self._payloads:
            return False
        payloads = [samples[0] for samples in arrived.values() if len(samples) == 1]
        usual = [payload for payload in payloads if payload is not None]
        if len(usual) < len(arrived) or not self._reader.are_beacons(tick, list(arrived), usual):
            return False
        self._payloads[tick] = dict(zip(arrived, usual, strict=True))
        return True

    async def judge(self, tick: int, decodable: Bools) -> tuple[list[bytes], Faults]:
        """The payload of each robot's Beacon of `tick`, in id order, and the `decodable` [n] robots at fault.

        A robot whose beacon is missing is asked for it once, since junk may have pushed it out of the mailbox.
        """
        payloads = self._collect(tick, decodable)
        missing: list[int] = []
        if not all(payloads):
            missing = [robot for robot in np.flatnonzero(decodable).tolist() if not payloads[robot]]
        if not (missing or self._faults):
            return payloads, {}
        answers = await asyncio.gather(*(self._recall(robot, tick) for robot in missing))
        faults = dict(self._faults.pop(tick - 1, {}))  # of a beacon that arrived after the judgement of its tick
        for robot, answer in zip(missing, answers, strict=True):
            payloads[robot] = answer if isinstance(answer, bytes) else b""
            if isinstance(answer, str):
                faults[robot] = answer
            else:
                self._payloads.setdefault(tick, {})[robot] = answer
        faults |= self._faults.pop(tick, {})
        return payloads, {robot: shown(fault) for robot, fault in faults.items() if decodable[robot]}

    def _on_recall(self, query: Query) -> None:
        """Answer a robot that misses a beacon with the copy by which its sender was judged."""
        tick, robot = messages.decode_recall(query.payload), query.key.split("/")[-2]
        beacons = {str(sender): payload for sender, payload in enumerate(self._judged.get(tick, [])) if payload}
        if robot in beacons:
            query.reply(beacons[robot], "fes.Beacon")
        else:
            query.reply_err(f"the world holds no beacon of robot {shown(robot)} from tick {tick}")

    def _sort(self, robot: int, tick: int, samples: list[bytes | None]) -> None:
        """Sort the beacons of a mailbox by tick."""
        for payload in samples:
            try:
                beacon = self._decoded(payload, robot)
            except MessageError:
                continue  # its peers count and log it
            if beacon.tick > tick + 1:
                if self._guarded:  # a peer may have stored it for that later tick
                    self._faults.setdefault(tick, {})[robot] = f"it sent a beacon ahead of its time at tick {tick}"
                continue
            if beacon.tick < tick - 1:
                continue
            assert payload is not None
            first = self._payloads.setdefault(beacon.tick, {}).setdefault(robot, payload)
            if payload != first:
                fault = f"it sent two different beacons for tick {beacon.tick}"
                self._faults.setdefault(beacon.tick, {})[robot] = fault

    async def _recall(self, robot: int, tick: int) -> bytes | str:
        """The beacon that a robot sends again on request, or its fault."""
        key, missing = keys.recall(self._run, robot), f"no readable beacon of tick {tick}"
        end = time.monotonic() + RECALL_TIMEOUT
        while True:
            left = end - time.monotonic()
            if left <= 0.0:
                return f"{missing}, and it did not repeat it within {RECALL_TIMEOUT:g} s"
            try:
                payload = await self._bus.get(key, messages.encode_recall(tick), left)
                beacon = self._decoded(payload, robot)
                break
            except (Overloaded, Unavailable):  # its queue may be full, or its session new
                await asyncio.sleep(RETRY)
            except Rejected as refusal:
                return f"{missing}, and it refused to repeat it: {refusal}"
            except MessageError as error:
                return f"{missing}, and it repeated junk: {error}"
        if beacon.tick != tick:
            return f"{missing}, and it repeated that of tick {beacon.tick}"
        self._drops.reject("Beacon: recalled", f"by a full mailbox: a beacon of robot {robot}; it was recalled")
        return payload

    def _decoded(self, payload: bytes | None, robot: int) -> Beacon:
        """The beacon of this robot in a payload; raises MessageError if a peer could not use it."""
        if payload is None:
            raise MessageError("Beacon", "a deletion is not a beacon")
        beacon = messages.decode_beacon(payload)
        if beacon.robot != robot:
            raise MessageError("Beacon", "came on another robot's key", str(beacon.robot))
        if len(beacon.links) and beacon.links[-1] >= self._robots:
            raise MessageError("Beacon", "has a link to a robot that does not exist", str(beacon.links[-1]))
        return beacon
