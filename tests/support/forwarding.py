"""A relay of sealed beacons on one machine: what a robot sends goes to all others whose address is known."""

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import cast

from fes.protocol import sealed

Address = tuple[str, int]


class Forwarding(asyncio.DatagramProtocol):
    """The relay's socket, with a choice of the datagrams that pass."""

    def __init__(self, passes: Callable[[int, int, bytes], bool]) -> None:
        self.passes = passes
        """True for a datagram from a robot to another that is forwarded."""
        self.robots: dict[int, Address] = {}
        self.datagrams: list[bytes] = []
        """Every datagram that has come from a robot."""
        self.foreign = 0
        self.transport: asyncio.DatagramTransport

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self.transport = cast(asyncio.DatagramTransport, transport)

    def datagram_received(self, data: bytes, addr: Address) -> None:
        robot = sealed.sender(data)
        if robot is None:
            self.foreign += 1
            return
        self.robots[robot] = addr
        self.datagrams.append(data)
        for peer, address in self.robots.items():
            if self.passes(robot, peer, data):
                self.transport.sendto(data, address)

    def inject(self, robot: int, data: bytes) -> None:
        """Send any bytes to a robot."""
        self.transport.sendto(data, self.robots[robot])


@asynccontextmanager
async def forwarding(
    passes: Callable[[int, int, bytes], bool] = lambda robot, peer, _: robot != peer,
) -> AsyncIterator[tuple[Forwarding, str]]:
    """A relay for the length of a block, and its host:port."""
    loop = asyncio.get_running_loop()
    transport, protocol = await loop.create_datagram_endpoint(lambda: Forwarding(passes), local_addr=("127.0.0.1", 0))
    try:
        port = transport.get_extra_info("sockname")[1]
        yield protocol, f"127.0.0.1:{port}"
    finally:
        transport.close()
