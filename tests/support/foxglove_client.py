"""A client of a Foxglove WebSocket server, after the protocol's description; it decodes by the advertised schemas.

It knows nothing of this project: neither the topics nor the message types.
"""

import asyncio
import base64
import importlib.util
import struct
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import pytest
from google.protobuf import descriptor_pb2, descriptor_pool, json_format, message_factory
from google.protobuf.message import Message

from fes.system import distribution, strict_json
from tests.support.processes import PATIENCE

needs_foxglove = pytest.mark.skipif(
    any(importlib.util.find_spec(package) is None for package in ("foxglove", "websockets")),
    reason=f"foxglove-sdk or websockets is not installed; these tests run after {distribution.install('dev')}",
)

PROTOCOL = "foxglove.sdk.v1"
MESSAGE, TIME = 1, 2
"""Kinds of binary frames from a server."""


class Channel(NamedTuple):
    """A channel as its server advertises it."""

    topic: str
    encoding: str
    schema_name: str
    schema: bytes


class Received(NamedTuple):
    """A message as it arrived."""

    topic: str
    time: int
    """Of the message [ns]."""
    payload: bytes
    message: Message
    """Decoded by the schema of its channel."""


@dataclass
class Client:
    """A client that subscribes to all channels, and keeps all that it receives."""

    socket: Any
    channels: dict[str, Channel] = field(default_factory=dict)
    received: list[Received] = field(default_factory=list)
    latest: dict[str, Received] = field(default_factory=dict)
    """The last message of each topic."""
    sessions: list[str] = field(default_factory=list)
    """Id of each session that the server has announced."""
    capabilities: list[str] = field(default_factory=list)
    """Parts of the protocol that the server offers beside its channels."""
    times: list[int] = field(default_factory=list)
    """Each time of the server [ns]."""
    _topics: dict[int, str] = field(default_factory=dict)
    _types: dict[str, type[Message]] = field(default_factory=dict)

    async def until(self, holds: "Condition") -> None:
        """Receive until a condition holds; fails after PATIENCE, and if the server leaves before."""
        async with asyncio.timeout(PATIENCE):
            while not holds(self):
                await self._take(await self.socket.recv())

    async def _take(self, frame: str | bytes) -> None:
        if isinstance(frame, bytes):
            self._take_binary(frame)
            return
        table = strict_json.loads(frame)
        if table["op"] == "serverInfo":
            self.sessions.append(table["sessionId"])
            self.capabilities = table["capabilities"]
        elif table["op"] == "advertise":
            for channel in table["channels"]:
                await self._subscribe(channel)

    async def _subscribe(self, channel: dict[str, Any]) -> None:
        assert (channel["encoding"], channel["schemaEncoding"]) == ("protobuf", "protobuf")
        schema = base64.b64decode(channel["schema"])
        topic, name, number = channel["topic"], channel["schemaName"], channel["id"]
        assert topic not in self.channels
        self.channels[topic] = Channel(topic, channel["encoding"], name, schema)
        self._topics[number] = topic
        self._types[topic] = message_type(name, schema)
        subscription = {"id": number, "channelId": number}
        await self.socket.send(strict_json.dumps({"op": "subscribe", "subscriptions": [subscription]}))

    def _take_binary(self, frame: bytes) -> None:
        if frame[0] == TIME:
            self.times.append(struct.unpack_from("<Q", frame, 1)[0])
        elif frame[0] == MESSAGE:
            subscription, time = struct.unpack_from("<IQ", frame, 1)
            topic, payload = self._topics[subscription], frame[13:]
            self.latest[topic] = Received(topic, time, payload, self._types[topic].FromString(payload))
            self.received.append(self.latest[topic])


Condition = Callable[[Client], Any]
"""A condition on what a client has received."""


@asynccontextmanager
async def connected(port: int) -> AsyncIterator[Client]:
    """A client of the server at a port of the loopback interface."""
    from websockets.asyncio.client import connect
    from websockets.typing import Subprotocol

    address, protocols = f"ws://127.0.0.1:{port}", [Subprotocol(PROTOCOL)]
    async with connect(address, subprotocols=protocols, max_size=None, proxy=None, close_timeout=1.0) as socket:
        yield Client(socket)


def message_type(name: str, schema: bytes) -> type[Message]:
    """The message type of a name in a binary FileDescriptorSet."""
    pool = descriptor_pool.DescriptorPool()
    for file in descriptor_pb2.FileDescriptorSet.FromString(schema).file:
        pool.Add(file)
    found: type[Message] = message_factory.GetMessageClass(pool.FindMessageTypeByName(name))
    return found


def fields(message: Message) -> dict[str, Any]:
    """The fields of a message, by their names in the schema; NaN equals itself."""
    table: dict[str, Any] = json_format.MessageToDict(
        message, preserving_proto_field_name=True, always_print_fields_with_no_presence=True
    )
    return table
