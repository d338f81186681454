"""The server of a page: it listens on loopback only, and no other origin opens its WebSocket."""

import asyncio
import os
import re
import socket
import urllib.request
from pathlib import Path

import pytest

pytest.importorskip("bokeh", reason="Bokeh is not installed: pip install -e '.[web]' in a clone")

from bokeh.document import Document
from bokeh.models import Button
from websockets.asyncio.client import connect
from websockets.exceptions import InvalidStatus

from console.web import page, server
from console.web.controls import Send
from console.web.facts import RunFacts
from console.web.feed import Feed
from fes.errors import FesError
from tests.support.frames import a_report
from tests.support.processes import PATIENCE


def listening() -> set[tuple[str, int]]:
    """Addresses and ports at which this process listens."""
    inodes = {os.readlink(path) for path in Path("/proc/self/fd").iterdir() if path.is_symlink()}
    ports = set()
    for table in ("tcp", "tcp6"):
        for line in Path(f"/proc/self/net/{table}").read_text().splitlines()[1:]:
            _, local, _, state, *rest = line.split()
            if state == "0A" and f"socket:[{rest[5]}]" in inodes:
                host, _, number = local.partition(":")
                parts = [str(int(host[place : place + 2], 16)) for place in range(0, len(host), 2)]
                ports.add((".".join(reversed(parts)), int(number, 16)))
    return ports


def make_page(send: Send | None, made: list[Document]) -> "server.MakePage":
    shown = Feed()
    shown.add(a_report([(0.0, 0.0), (60.0, 0.0)], [(0, 1)]))

    def make(doc: Document) -> None:
        page.Page(doc, shown, RunFacts("test"), send, None)
        made.append(doc)

    return make


def token(address: str) -> tuple[str, str]:
    """The token of a new page of the server, and the header that forbids frames."""
    with urllib.request.urlopen(address, timeout=PATIENCE) as answer:
        found = re.search(r'"token":"([^"]+)"', answer.read().decode())
        assert found is not None
        return found[1], answer.headers["X-Frame-Options"]


def test_only_an_origin_of_the_server_itself_opens_its_websocket() -> None:
    async def main() -> None:
        before = listening()
        async with server.opened(0, make_page(None, [])) as address:
            port = int(address.rstrip("/").rpartition(":")[2])
            assert listening() - before == {("127.0.0.1", port)}
            secret, frames = await asyncio.to_thread(token, address)
            assert frames == "DENY"
            uri, protocols = f"ws://127.0.0.1:{port}/ws", ["bokeh", secret]
            for origin in ("http://evil.example", f"http://evil.example:{port}", "http://127.0.0.1:1", "null"):
                with pytest.raises(InvalidStatus, match="403"):
                    await connect(uri, origin=origin, subprotocols=protocols)  # type: ignore[arg-type]
            for host in ("127.0.0.1", "localhost"):
                origin = f"http://{host}:{port}"
                async with connect(uri, origin=origin, subprotocols=protocols) as opened:  # type: ignore[arg-type]
                    assert '"ACK"' in str(await opened.recv())
        assert listening() == before

    asyncio.run(asyncio.wait_for(main(), PATIENCE))


@pytest.mark.parametrize("may_change", [True, False])
def test_only_the_page_of_an_operator_has_a_button(may_change: bool) -> None:
    made: list[Document] = []

    async def send(path: str, value: object) -> str:
        return f"{path} = {value}"

    async def main() -> None:
        async with server.opened(0, make_page(send if may_change else None, made)) as address:
            await asyncio.to_thread(token, address)

    asyncio.run(asyncio.wait_for(main(), PATIENCE))
    [document] = made
    assert bool(list(document.select({"type": Button}))) is may_change


def test_a_port_that_is_taken_is_refused_in_one_line() -> None:
    async def main() -> None:
        with socket.socket() as taken:
            taken.bind(("127.0.0.1", 0))
            taken.listen()
            port = taken.getsockname()[1]
            words = rf"^--port {port}: Address already in use; --port 0 takes a free one$"
            with pytest.raises(FesError, match=words):
                async with server.opened(port, make_page(None, [])):
                    pass

    asyncio.run(main())


def test_a_page_whose_update_is_interrupted_by_the_end_logs_no_error(caplog: pytest.LogCaptureFixture) -> None:
    async def main() -> None:
        is_updating = asyncio.Event()

        async def update() -> None:
            is_updating.set()
            await asyncio.sleep(PATIENCE)

        def make(doc: Document) -> None:
            doc.add_periodic_callback(update, 10)

        async with server.opened(0, make) as address:
            await asyncio.to_thread(token, address)
            await is_updating.wait()

    asyncio.run(asyncio.wait_for(main(), PATIENCE))
    assert caplog.text == ""
