"""The flags of a page, and its programs: for a running run here, for a log in `console.replay.page`.

Bokeh comes with the extra `web`, and is imported only to serve a page.
"""

import asyncio
import contextlib
import functools
import ipaddress
import os
import sys
from importlib.util import find_spec
from typing import TYPE_CHECKING, Annotated, Any

import typer

from console.connect import channel_request, index_source
from console.terminal import printing
from console.web import feed
from console.web.facts import RunFacts
from console.web.feed import Feed
from fes.errors import FesError
from fes.protocol.channel_change import ParameterChange
from fes.system.distribution import install
from fes.transport.bus import Bus
from fes.transport.endpoints import Endpoints
from world.config import remarks

if TYPE_CHECKING:
    from console.web.page import Source
    from console.web.slider import TimeSlider

PORT = 5006
"""Default port of a page."""

ANSWER = 5.0
"""Longest wait for the world's answer to a change [s]."""

NICENESS = 10
"""Niceness of the server: on a busy machine it yields the processor to the run."""

Web = Annotated[bool, typer.Option("--web", help="Show a page in a browser, instead of a dashboard.")]
Port = Annotated[
    int | None,
    typer.Option(min=0, max=65535, help=f"Port of --web ({PORT} by default), on loopback; 0: any."),
]
Operator = Annotated[
    bool, typer.Option("--operator", help="With --web: use the operator's certificate, and show controls.")
]


def require() -> None:
    """Raise FesError if Bokeh is missing."""
    if find_spec("bokeh") is None:
        raise FesError(f"a page needs bokeh: {install('web')}")


async def watch(bus: Bus, run: str, timeout: float, port: int, about: RunFacts, may_change: bool) -> None:
    """Serve the page of a running run until a signal; raises Unavailable if no world appears within `timeout` [s]."""
    shown = Feed()

    async def send(path: str, value: Any) -> str:
        result = await channel_request.send(bus, run, ParameterChange(path, value), ANSWER)
        return channel_request.described(result) + (f" ({remarks.UNNOTICED})" if result.unnoticed else "")

    await serve(port, shown, about, feed.follow(bus, run, timeout, shown), send=send if may_change else None)


async def serve(
    port: int,
    source: "Source",
    about: RunFacts,
    work: Any,
    *,
    send: Any = None,
    slider: "functools.partial[TimeSlider] | None" = None,
) -> None:
    """Serve a page, and print its address, while `work` supplies its source; until a signal."""
    from console.web import page, server

    os.nice(NICENESS)

    def make_page(doc: Any) -> None:
        page.Page(doc, source, about, send, slider() if slider else None)

    async with contextlib.AsyncExitStack() as stack:
        stack.callback(work.close)
        address = await stack.enter_async_context(server.opened(port, make_page))
        printing.line(address)
        sys.stdout.flush()  # a pipe would buffer it
        await work
        await asyncio.Event().wait()


def may_change(endpoints: Endpoints) -> bool:
    """True if a page may have controls without a certificate: the run speaks plainly, on this machine only.

    Settings of Zenoh could name another machine, or a certificate.
    """
    is_plain = not endpoints.security and endpoints.config_file is None and not endpoints.settings
    return is_plain and all(_is_loopback(endpoint) for endpoint in endpoints.connect)


def facts_of(run: str, endpoints: Endpoints) -> RunFacts:
    """The facts about the run at these endpoints, with its seed and its index if it was started in this folder."""
    started = index_source.started_here(run, endpoints)
    if started is None:
        return RunFacts(run)
    directory, loaded = started
    return RunFacts(f"{run} in {directory}", loaded.run.seed, index_source.of(loaded))


def _is_loopback(endpoint: str) -> bool:
    host = endpoint.partition("/")[2].rpartition(":")[0].strip("[]")
    with contextlib.suppress(ValueError):
        return ipaddress.ip_address(host).is_loopback
    return host == "localhost"
