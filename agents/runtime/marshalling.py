"""Messages into a crew's arrays, and back."""

from collections.abc import Iterator

import numpy as np

from fes.arrays.edges import Stack
from fes.arrays.types import Floats, Ints
from fes.model.sensing import Beacons, Observations, Telemetry, no_beacons
from fes.protocol import messages
from fes.protocol.messages import Beacon, Command, Observation


class MessageAssembler:
    """Stacks the messages of one process; keeps arrays that did not change, so that nobody recomputes."""

    def __init__(self, ids: Ints) -> None:
        self._ids = ids
        self._in_range = Stack()
        self._senders: list[int] = []
        self._sender_ids: Ints = no_beacons().ids
        self._links = Stack()

    def observations(self, received: list[Observation]) -> Observations:
        """One observation of each robot of the crew, in id order, as arrays."""
        edges = self._in_range.edges(self._ids, [message.in_range for message in received])
        poses = np.array([message.pose for message in received])
        reception = np.concatenate([message.reception for message in received])
        return Observations(received[0].tick, poses, edges, reception)

    def beacons(self, tick: int, received: list[Beacon]) -> Beacons:
        """The beacons of one tick, in id order, as arrays."""
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
        )

    @staticmethod
    def _statistics(received: list[Floats]) -> Floats:
        """Statistics [n, q]; those of a sender with another number of them count as not measured (zeros)."""
        q = max(len(one) for one in received)
        return np.array([one if len(one) == q else np.zeros(q) for one in received]).reshape(len(received), q)


def encode_tick(said: Beacons, twists: Floats, told: Telemetry) -> Iterator[tuple[int, bytes, bytes]]:
    """For each robot its id, and the payloads of its beacon and its command; `told` is the crew's telemetry."""
    named = said.selected.view(np.uint8)
    spans = zip(said.links.spans, told.links.spans, strict=True)  # they are others where a transmitter is late
    rows = zip(said.ids.tolist(), said.poses.tolist(), twists.tolist(), spans, said.statistics, strict=True)
    for robot, pose, twist, (at, own), statistics in rows:
        links, estimates = said.links.peers[at], said.estimates[at]
        beacon = Beacon(said.tick, robot, tuple(pose), links, estimates, named[at], statistics)
        links, estimates = told.links.peers[own], told.estimates[own]
        command = Command(said.tick, robot, tuple(twist), links, estimates, told.learnt[:, own].ravel())
        yield robot, messages.encode_beacon(beacon), messages.encode_command(command)
