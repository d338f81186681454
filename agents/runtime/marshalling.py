"""Marshalling between messages and a crew's arrays."""

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from agents.control.transmitter import RobotPayloads
from fes.arrays.edges import Stack
from fes.arrays.types import Bytes, Floats, Ints
from fes.model.sensing import Beacons, Observations, Telemetry, no_beacons
from fes.protocol import packing, wire
from fes.protocol.messages import Beacon, Observation

Number = TypeVar("Number", bound=np.generic)


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
        reception = _joined([message.reception for message in received])
        tick = received[0].tick
        is_new = all(message.fixed is None or message.fixed == tick for message in received)
        fixed = (
            None if is_new else np.array([tick if message.fixed is None else message.fixed for message in received])
        )
        return Observations(tick, poses, edges, reception, fixed)

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
            _joined([message.estimates for message in received]),
            _joined([message.selected for message in received]).view(np.bool_),
            self._statistics([message.statistics for message in received]),
            self._declared([message.declared for message in received]),
        )

    @staticmethod
    def _statistics(received: list[Floats]) -> Floats:
        """Statistics [n, q], with q the largest number received; zeros for a sender with fewer, as if unmeasured."""
        q = max(map(len, received))
        if not q:
            return np.empty((len(received), 0))
        return _joined([row if len(row) == q else np.zeros(q) for row in received]).reshape(len(received), q)

    @staticmethod
    def _declared(received: list[bytes]) -> Bytes:
        """Declared bytes [n, b], with b the largest number received; zeros for a sender with fewer."""
        b = max(map(len, received))
        rows = [row if len(row) == b else bytes(b) for row in received]
        return np.frombuffer(b"".join(rows), dtype=np.uint8).reshape(len(received), b)


def _joined(rows: list[NDArray[Number]]) -> NDArray[Number]:
    """The rows, one after the other; not copied if there is only one."""
    return rows[0] if len(rows) == 1 else np.concatenate(rows)


def encode_tick(beacons: Beacons, twists: Floats, telemetry: Telemetry) -> list[RobotPayloads]:
    """Id, beacon payload and command payload of each robot.

    Each array becomes bytes once, and each robot gets its share of them.
    """
    links, own = beacons.links, telemetry.links  # a late transmitter sends other links than its robot has
    peers, estimates = wire.id_bytes(links.peers), beacons.estimates.tobytes()
    selected, declared = beacons.selected.tobytes(), beacons.declared.tobytes()
    statistics, details = beacons.statistics.tobytes(), telemetry.details.tobytes()
    own_peers, own_estimates = wire.id_bytes(own.peers), telemetry.estimates.tobytes()
    q, b, j = 8 * beacons.statistics.shape[1], beacons.declared.shape[1], 8 * telemetry.details.shape[1]
    k, learnt = len(telemetry.learnt), telemetry.learnt
    payloads = []
    robots = zip(beacons.ids.tolist(), beacons.poses.tolist(), twists.tolist(), links.spans, own.spans, strict=True)
    for row, (robot, pose, twist, span, own_span) in enumerate(robots):
        begin, end = span.start, span.stop
        beacon = packing.pack_beacon(
            beacons.tick,
            robot,
            pose,
            peers[4 * begin : 4 * end],
            estimates[8 * begin : 8 * end],
            selected[begin:end],
            statistics[q * row : q * row + q],
            declared[b * row : b * row + b],
        )
        begin, end = own_span.start, own_span.stop
        command = packing.pack_command(
            beacons.tick,
            robot,
            twist,
            own_peers[4 * begin : 4 * end],
            own_estimates[8 * begin : 8 * end],
            learnt[:, own_span].tobytes() if k else b"",
            details[j * row : j * row + j],
            telemetry.is_model_free,
        )
        payloads.append((robot, beacon, command))
    return payloads
