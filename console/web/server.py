"""A Bokeh server on the loopback interface, which makes a page for each browser that connects."""

import contextlib
import errno
import logging
import socket
from collections.abc import AsyncIterator, Callable

from bokeh.application import Application
from bokeh.application.handlers.function import FunctionHandler
from bokeh.document import Document
from bokeh.server.server import BaseServer
from bokeh.server.tornado import BokehTornado
from tornado.httpserver import HTTPServer
from tornado.httputil import HTTPHeaders
from tornado.ioloop import IOLoop
from tornado.web import OutputTransform, RequestHandler

from fes.errors import FesError, reason

HOST = "127.0.0.1"

BACKLOG = 128
"""Largest number of connections that wait to be accepted."""

ABSENCE = 5.0
"""Time after which the page of a closed browser is discarded [s]."""

MakePage = Callable[[Document], None]
"""Fills a new document for a browser. Bokeh requires that its argument is called `doc`."""

LONGEST = 1 << 20
"""Longest message from a browser [bytes]."""


class _NoFrames(OutputTransform):
    """Forbids other pages to embed this one in a frame: a person could press its buttons without seeing them."""

    def transform_first_chunk(
        self, status_code: int, headers: HTTPHeaders, chunk: bytes, finishing: bool
    ) -> tuple[int, HTTPHeaders, bytes]:
        headers["X-Frame-Options"] = "DENY"
        headers["Content-Security-Policy"] = "frame-ancestors 'none'"
        return status_code, headers, chunk


class _Quiet(BokehTornado):  # type: ignore[misc]
    """Logs no request: a person's terminal shows the address only."""

    def log_request(self, handler: RequestHandler) -> None:
        pass


@contextlib.asynccontextmanager
async def opened(port: int, make_page: MakePage) -> AsyncIterator[str]:
    """The address of a server that runs within the block; raises FesError in one line for a port that is taken.

    Only a page of this server can open its WebSocket: another origin, such as a page of the web, is rejected.
    """
    listener = socket.socket()
    try:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind((HOST, port))
        listener.listen(BACKLOG)
    except OSError as error:
        listener.close()
        advice = "; --port 0 takes a free one" if error.errno == errno.EADDRINUSE else ""
        raise FesError(f"--port {port}: {reason(error)}{advice}") from None
    listener.setblocking(False)
    bound = listener.getsockname()[1]
    application = _Quiet(
        {"/": Application(FunctionHandler(make_page))},
        extra_websocket_origins=[f"{HOST}:{bound}", f"localhost:{bound}"],
        unused_session_lifetime_milliseconds=round(1000 * ABSENCE),
        check_unused_sessions_milliseconds=round(1000 * ABSENCE),
        websocket_max_message_size_bytes=LONGEST,
    )
    application.add_transform(_NoFrames)
    logging.getLogger("bokeh").setLevel(logging.ERROR)  # no warning of browsers that close
    http = HTTPServer(application)
    server = BaseServer(IOLoop.current(), application, http)
    http.add_sockets([listener])
    server.start()
    try:
        yield f"http://{HOST}:{bound}/"
    finally:
        for name in ("bokeh", "tornado.application"):
            logging.getLogger(name).setLevel(logging.CRITICAL)  # no error of an update that the end interrupts
        http.stop()
        await http.close_all_connections()
        server.stop()
