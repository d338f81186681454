"""What the robots say to each other, heard by a world that keeps a log of it."""

from fes import keys, wire
from fes.arrays import Bools
from fes.bus import Bus
from fes.complaints import Complaints


class Ears:
    """One box of beacons for each robot.

    A robot puts its beacon before its command, and both come through this process's router in that order: when the
    commands of a tick are here, so are its beacons.
    """

    def __init__(self, bus: Bus, run: str, robots: int, complaints: Complaints) -> None:
        self._boxes = [bus.mailbox(keys.beacon(run, robot)) for robot in range(robots)]
        self._early: dict[int, bytes] = {}
        """The beacon of the next tick of a robot that is quick."""
        self._complaints = complaints

    def heard(self, tick: int, legible: Bools) -> list[bytes]:
        """The payload of each robot's beacon of a tick, in id order; empty for those that are not `legible` [n]."""
        found = [self._beacon(robot, tick) if here else b"" for robot, here in enumerate(legible.tolist())]
        for robot, payload in enumerate(found):
            if not payload and legible[robot]:
                self._complaints.miss("beacons in the log", f"no beacon of robot {robot} came for tick {tick}")
        return found

    def _beacon(self, robot: int, tick: int) -> bytes:
        early = self._early.pop(robot, b"")
        if early and wire.peek(early) == (tick, robot):
            return early
        box = self._boxes[robot]
        while (sample := box.take()) is not None:
            payload = sample[1]
            stamp = wire.peek(payload) if payload is not None else None
            if payload is None or stamp is None or stamp[1] != robot:
                continue  # junk: the robots' own ears complain of it
            if stamp[0] == tick:
                return payload
            if stamp[0] == tick + 1:
                self._early.setdefault(robot, payload)
        return b""
