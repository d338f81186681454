"""The vendor's driver over Zenoh: poses come in, twists go out; other programs that command the body are detected.

Handlers of Zenoh run in its threads. They only append to a bounded queue, and wake the loop.
"""

import asyncio
import os
import time
from collections import deque
from collections.abc import Callable

from fes.ros import graph, topics
from fes.ros.messages import write_twist
from fes.transport import foreign
from fes.transport.bus import Bus
from field.gate.rules.frames import Twist
from field.gate.rules.settings import BodySettings

MOST_WAITING = 256
"""Most samples that wait for the loop; the oldest is dropped."""

ZEROS = 5
"""Zero commands at the end: one may be lost."""

NODE = "fes_gate"
"""Name of this process in the graph of ROS 2."""


class Arrivals:
    """Samples on their way from threads of Zenoh to the loop, each with the time of its arrival."""

    def __init__(self, loop: asyncio.AbstractEventLoop, wake: Callable[[], None]) -> None:
        self._loop = loop
        self._wake = wake
        self._waiting: deque[tuple[int, str, bytes]] = deque(maxlen=MOST_WAITING)
        self._is_woken = False

    def put(self, key: str, payload: bytes | None, attachment: bytes = b"") -> None:
        """Append a sample; called in a thread of Zenoh."""
        self._waiting.append((time.monotonic_ns(), key, payload or b""))
        if not self._is_woken:
            self._is_woken = True
            self._loop.call_soon_threadsafe(self._wake)

    def take(self) -> list[tuple[int, str, bytes]]:
        """The samples that wait: time [ns], key and payload; the oldest first."""
        self._is_woken = False  # before the samples, so that none stays without a wake-up
        samples: list[tuple[int, str, bytes]] = []
        while len(samples) < MOST_WAITING and self._waiting:
            samples.append(self._waiting.popleft())
        return samples


class Driver:
    """The topics of a body."""

    def __init__(self, bus: Bus, settings: BodySettings, wake: Callable[[], None]) -> None:
        loop = asyncio.get_running_loop()
        self.poses = Arrivals(loop, wake)
        """Payloads of poses."""
        self.rivals = Arrivals(loop, wake)
        """Commands of other programs."""
        self._topic = settings.command_topic
        self._session = str(bus.session.zid())
        self._gid = os.urandom(topics.GID_LENGTH)
        self._sequence = 0
        self._publishers: dict[str, str] = {}
        self._put = foreign.declare_publisher(bus, topics.publish_key(self._topic))
        for token in graph.tokens(
            graph.Node(self._session, NODE, domain=settings.domain), (self._topic,), (settings.pose_topic,)
        ):
            bus.declare_token(token)
        bus.declare_liveliness_subscriber(graph.publishers(self._topic), self._on_publisher)
        foreign.declare_subscriber(bus, topics.subscribe_key(self._topic), self.rivals.put, remote_only=True)
        foreign.declare_subscriber(bus, topics.subscribe_key(settings.pose_topic), self.poses.put)

    @property
    def other_publishers(self) -> list[str]:
        """Programs in the graph of ROS 2 that could command the body, by name."""
        return sorted({*self._publishers.values()})

    def put(self, twist: Twist) -> None:
        """Send a twist [m/s, rad/s; body]."""
        self._sequence += 1
        now = time.time_ns()  # a driver compares stamps with its own wall clock
        payload = write_twist(self._topic.type, *twist, stamp=now)
        self._put(payload, topics.attachment(self._topic, self._sequence, now, self._gid))

    def put_zeros(self, period: float) -> None:
        """Send the last commands, `period` [s] apart. It blocks the loop: nothing may come between them."""
        for _ in range(ZEROS):
            self.put((0.0, 0.0))
            time.sleep(period)

    def _on_publisher(self, token: str, alive: bool) -> None:
        endpoint = graph.parse_token(token)
        if not alive:
            self._publishers.pop(token, None)
        elif endpoint is not None and endpoint.session != self._session:
            self._publishers[token] = endpoint.node or "a node behind the bridge"
