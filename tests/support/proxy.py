"""A TCP link on loopback that a test can cut, delay and heal."""

import asyncio
import contextlib
from collections.abc import AsyncIterator

from console.backends.process_group import free_port


class Link:
    """Passes bytes between its clients and an endpoint."""

    def __init__(self, port: int) -> None:
        self.endpoint = f"tcp/127.0.0.1:{free_port()}"
        self._port = port
        self._flows = asyncio.Event()
        self._flows.set()
        self._is_cut = False
        self._writers: set[asyncio.StreamWriter] = set()

    def hold(self) -> None:
        """Forward nothing until `heal`."""
        self._flows.clear()

    def cut(self) -> None:
        """Close every connection, and accept none until `heal`."""
        self._is_cut = True
        for writer in list(self._writers):
            writer.close()

    def heal(self) -> None:
        """Forward everything again."""
        self._is_cut = False
        self._flows.set()

    async def serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """One connection, from its beginning to its end."""
        if self._is_cut:
            writer.close()
            return
        theirs, ours = await asyncio.open_connection("127.0.0.1", self._port)
        self._writers |= {writer, ours}
        try:
            with contextlib.suppress(asyncio.CancelledError):  # the test is over
                await asyncio.gather(self._pass(reader, ours), self._pass(theirs, writer))
        finally:
            for stream in (writer, ours):
                self._writers.discard(stream)
                stream.close()

    async def _pass(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        with contextlib.suppress(OSError):
            while chunk := await reader.read(1 << 16):
                await self._flows.wait()
                writer.write(chunk)
                await writer.drain()
        writer.close()


@contextlib.asynccontextmanager
async def link(endpoint: str) -> AsyncIterator[Link]:
    """A link to the endpoint `tcp/127.0.0.1:PORT`, at an endpoint of its own."""
    made = Link(int(endpoint.rpartition(":")[2]))
    async with await asyncio.start_server(made.serve, "127.0.0.1", int(made.endpoint.rpartition(":")[2])):
        yield made
