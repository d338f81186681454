"""Marshalling between messages and a crew's arrays."""

from collections.abc import Iterator

import numpy as np

from fes.arrays.edges import Stack
from fes.arrays.types import Bytes, Floats, Ints
from fes.model.sensing import Beacons, Observations, Telemetry, no_beacons
from fes.protocol import messages
from fes.protocol.messages import Beacon, Command, Observation


class MessageAssembler:
    """Stacks the messages of one process as arrays. Unchanged arrays are reused, and the crew need not recompute."""

    def __init__(self, ids: Ints) -> None:
        self._ids = ids
        self._in_range = Stack()
        self._senders: list[int] = []
        self._sender_ids: Ints = no_beacons().ids
        self._links = Stack()

    def observations(self, received: list[Observation]) -> Observations:
        """The observations of one tick as arrays; one per robot of the crew, in id order."""
        edges = self._in_range.edges(self._ids, [message.in_range for message in received])
        poses = np.array([message.pose for message in received])
        reception = np.concatenate([message.reception for message in received])
        return Observations(received[0].tick, poses, edges, reception)

    def beacons(self, tick: int, received: list[Beacon]) -> Beacons:
        """The beacons of one tick, in id order of their senders, as arrays."""
        if not received:
            return no_beacons()
        senders = [message.robot for message in received]
        if senders != self._senders:
            self._senders, self._sender_ids = senders, np.array(senders, dtype=np.int64)
        links = self._links.edges(self._sender_ids, [message.links for message in received])
        return Beacons(
            tick,
            self._sender_ids,
            np.array([message.pose for message in received]),
            links,
            np.concatenate([message.estimates for message in received]),
            np.concatenate([message.selected for message in received]).view(np.bool_),
            self._statistics([message.statistics for message in received]),
            self._declared([message.declared for message in received]),
        )

    @staticmethod
    def _statistics(received: list[Floats]) -> Floats:
        """Statistics [n, q], with q the largest number received; zeros for a sender with fewer, as if unmeasured."""
        q = max(map(len, received))
        return np.array([row if len(row) == q else np.zeros(q) for row in received]).reshape(len(received), q)

    @staticmethod
    def _declared(received: list[bytes]) -> Bytes:
        """Declared bytes [n, b], with b the largest number received; zeros for a sender with fewer."""
        b = max(map(len, received))
        rows = [row if len(row) == b else bytes(b) for row in received]
        return np.frombuffer(b"".join(rows), dtype=np.uint8).reshape(len(received), b)


def encode_tick(beacons: Beacons, twists: Floats, telemetry: Telemetry) -> Iterator[tuple[int, bytes, bytes]]:
    """Id, beacon payload and command payload of each robot."""
    selected = beacons.selected.view(np.uint8)
    spans = zip(beacons.links.spans, telemetry.links.spans, strict=True)  # a late transmitter sends other links
    robots = zip(beacons.ids.tolist(), beacons.poses.tolist(), twists.tolist(), strict=True)
    laws = zip(beacons.statistics, beacons.declared, telemetry.details, strict=True)
    for (robot, pose, twist), (sent, own), (statistics, declared, details) in zip(robots, spans, laws, strict=True):
        links, estimates = beacons.links.peers[sent], beacons.estimates[sent]
        numbers = statistics, declared.tobytes()
        beacon = Beacon(beacons.tick, robot, tuple(pose), links, estimates, selected[sent], *numbers)
        links, estimates = telemetry.links.peers[own], telemetry.estimates[own]
        learnt = telemetry.learnt[:, own].ravel()
        own_numbers = links, estimates, learnt, details
        command = Command(beacons.tick, robot, tuple(twist), *own_numbers, telemetry.is_model_free)
        yield robot, messages.encode_beacon(beacon), messages.encode_command(command)
