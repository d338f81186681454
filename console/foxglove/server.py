"""The WebSocket server of foxglove-sdk, which shows a running run to Foxglove and Lichtblick.

It is an observer of the run: a world sends its Reports in any case, and never waits for one. The server listens on
the loopback interface only. The package comes with the extra `foxglove`, and is imported only to serve.
"""

import asyncio
import contextlib
from collections.abc import AsyncIterator, Callable, Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from google.protobuf.message import Message

from console.connect import observer
from console.foxglove import messages
from fes import process
from fes.errors import FesError
from fes.protocol.report import Report
from fes.recording.protobuf import describe
from fes.system.distribution import install
from fes.transport.bus import Bus

if TYPE_CHECKING:
    from foxglove import Channel, Context
    from foxglove.websocket import ChannelView, Client, ServerListener, WebSocketServer

HOST = "127.0.0.1"
"""The only address on which the server listens."""

PORT = 8765
"""Usual port of a Foxglove WebSocket server."""

IDLE = 0.25
"""Longest wait for a Report before the observer looks again for the world [s]."""

LAYOUT = Path(__file__).with_name("layout.json")
"""A layout for the topics of a running run and of its log."""


async def serve(session: contextlib.AbstractAsyncContextManager[Bus], run: str, timeout: float, port: int) -> int:
    """Serve the topics of a run until a signal comes; the last state stays when the run is over.

    Raises FesError if the package is missing or the port is in use, and Unavailable as `observer.reports` does.
    """
    with opened(port) as viewers:
        process.tell(f"run '{run}' at ws://{HOST}:{viewers.port}, for the layout {LAYOUT}")
        async with session as bus:
            await viewers.follow(observer.reports(bus, run, timeout, IDLE))
        process.tell(f"the run is over after tick {viewers.tick}; its last state stays until Ctrl-C")
        await asyncio.Event().wait()
    return process.SUCCESS


@contextlib.contextmanager
def opened(port: int) -> Iterator["Viewers"]:
    """A server within a block, in an event loop; port 0 stands for any free one. Raises FesError."""
    if find_spec("foxglove") is None:
        raise FesError(f"--foxglove needs foxglove-sdk: {install('foxglove')}")
    import foxglove
    from foxglove.websocket import Capability

    context, loop = foxglove.Context(), asyncio.get_running_loop()

    def repeat(topic: str) -> None:
        with contextlib.suppress(RuntimeError):  # the loop has ended
            loop.call_soon_threadsafe(lambda: viewers.repeat(topic))

    try:
        server = foxglove.start_server(
            name="fes",
            host=HOST,
            port=port,
            context=context,
            capabilities=[Capability.Time],
            server_listener=_subscriptions(repeat),
        )
    except RuntimeError as error:  # "FoxgloveError: Failed to bind port: Address already in use (os error 98)"
        raise FesError(f"cannot listen at {HOST}:{port}: {str(error).rpartition(': ')[2]}") from None
    viewers = Viewers(server, context)
    try:
        yield viewers
    finally:
        server.stop()


class Viewers:
    """The clients of a server, which receive the topics of each Report."""

    def __init__(self, server: "WebSocketServer", context: "Context") -> None:
        self.port = server.port
        self.tick = -1
        """Tick of the last Report, -1 before the first."""
        self._server, self._context = server, context
        self._channels: dict[str, Channel] = {}
        self._last: dict[str, bytes] = {}
        self._robots = self._time = 0

    async def follow(self, reports: AsyncIterator[Report | None]) -> None:
        """Send each Report to the clients until the Reports end; None stands for a time without one."""
        async for report in reports:
            if report is not None:
                self.show(report)

    def show(self, report: Report) -> None:
        """Send the topics of a Report.

        A world that resumes a run repeats ticks. Viewers then start a new session, since their time went backward.
        """
        is_back = report.tick < self.tick
        if is_back:
            self._server.clear_session()
        self.tick, self._time = report.tick, messages.time_of(report)
        self._server.broadcast_time(self._time)
        if is_back or len(report.alive) != self._robots:
            self._robots = len(report.alive)
            self._send(messages.bodies(report))
        self._send(messages.of_report(report))

    def repeat(self, topic: str) -> None:
        """Send the last message of a topic again: a new subscriber lacks it, and another may never follow."""
        self._server.broadcast_time(self._time)
        self._channels[topic].log(self._last[topic], log_time=self._time)

    def _send(self, topics: Iterator[tuple[str, Message]]) -> None:
        for topic, message in topics:
            payload = self._last[topic] = message.SerializeToString()
            if topic not in self._channels:
                self._channels[topic] = _channel(self._context, topic, type(message))
            self._channels[topic].log(payload, log_time=self._time)


def _channel(context: "Context", topic: str, kind: type[Message]) -> "Channel":
    """A channel with the schema that a log has for this type."""
    from foxglove import Channel, Schema

    schema = Schema(name=kind.DESCRIPTOR.full_name, encoding="protobuf", data=describe(kind))
    return Channel(topic, schema=schema, message_encoding="protobuf", context=context)


def _subscriptions(on_topic: Callable[[str], None]) -> "ServerListener":
    """A listener that names the topic of each new subscription; a thread of the server calls it."""
    from foxglove.websocket import ServerListener

    class Subscriptions(ServerListener):
        """The callbacks of a server; only subscriptions have an effect."""

        def on_subscribe(self, client: "Client", channel: "ChannelView") -> None:
            """A client subscribes to a channel."""
            on_topic(channel.topic)

    return Subscriptions()
