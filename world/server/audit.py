"""The audit: rejected connections and denied messages, read from Zenoh's own log, one line per kind.

Zenoh drops a message that access control denies, and tells neither side. Only its log at the finest level shows it.
That log goes to the standard output of the process, which the world does not use, so a pipe takes its place.
The hot path is the search of a block of the log for marks; see docs/explanation/security.md for the cost.
"""

import contextlib
import fcntl
import logging
import os
import re
import sys
import threading
import time
from collections import Counter
from collections.abc import AsyncIterator, Iterable

from fes.transport import bus
from fes.transport.drop_log import DropLog

LEVELS = "off,zenoh::net::routing::interceptor::access_control=trace,zenoh_link_tls=warn"
PIPE = 1 << 20
"""Size of the pipe: the length of log by which the reader may lag behind [bytes]."""

PAUSE = 0.05
"""Pause of the reader between two blocks [s]. A shorter one would delay the world's own thread."""

KINDS_PER_NAME = 20
"""Largest number of kinds logged per certificate name: no client can fill the log or hide another client."""

MAX_NAMES = 10_000
"""Largest number of sessions whose names are stored."""

_MARKS = (b" is unauthorized to ", b" caching permissions ", b"zenoh_link_tls", b" did not match any ")

_DENIED = re.compile(
    rb"(?:: Using cached result: (?P<cached>[0-9a-f]+)"
    rb"|: (?P<zid>[0-9a-f]+) on [^\n]*?CertCommonName\((?P<name>[^)\n]*)\)[^\n]*)"
    rb" is unauthorized to (?P<act>[A-Za-z/ ]+) \((?P<flow>ingress|egress)\) on (?P<key>[^\n]*)"
)
_CACHING = re.compile(rb"ThreadId\((\d+)\)[^\n]*: ACL \((ingress|egress)\): caching permissions for `([^`\n]*)`")
_THREAD = re.compile(rb"ThreadId\((\d+)\)")
_STRANGER = re.compile(rb": ([0-9a-f]+) did not match any configured ACL subject")
_TLS = re.compile(rb"zenoh_link_tls[^\n]*?: (?P<why>(?:invalid peer certificate|received|peer)[^\n]*)")

REASONS = (
    (b"certificate expired", "its certificate has expired"),
    (b"received corrupt message", "it does not speak TLS"),
    (b"peer sent no certificates", "it has no certificate"),
    (b"received fatal alert", "it does not trust the world's certificate"),
    (b"invalid peer certificate", "its certificate is not of this run's authority"),
)
"""Zenoh's message about a failed connection, and its meaning."""


class Audit:
    """Rejected connections and messages by kind, from blocks of the log."""

    def __init__(self, logger: logging.Logger, roles: Iterable[str]) -> None:
        """`roles` are those of the run. All other names, even in a forged line, share one limit of kinds."""
        self._connections, self._others = DropLog(logger), DropLog(logger, KINDS_PER_NAME)
        self._by_role = {role: DropLog(logger, KINDS_PER_NAME, f"{role}: other") for role in roles}
        self._rest = b""
        self._names: dict[bytes, str] = {}
        self._caching: dict[bytes, tuple[bytes, bytes, set[bytes]]] = {}
        """Thread -> the permissions that it computes in advance: flow, key, and actions found to be denied."""

    @property
    def counts(self) -> Counter[str]:
        """Number of rejections by kind."""
        return sum((log.counts for log in self._logs()), Counter[str]())

    def log_total(self) -> None:
        """Log the total of each kind."""
        for log in self._logs():
            log.log_total()

    def _logs(self) -> list[DropLog]:
        return [self._connections, *self._by_role.values(), self._others]

    def feed(self, block: bytes) -> None:
        """Read a block of the log, which may begin and end within a line."""
        lines, newline, rest = (self._rest + block).rpartition(b"\n")
        self._rest = rest[-PIPE:]
        if newline and any(mark in lines for mark in _MARKS):
            for line in lines.split(b"\n"):
                self._read(line)

    def _read(self, line: bytes) -> None:
        if match := _DENIED.search(line):
            self._on_denial(line, match)
        elif match := _CACHING.search(line):
            self._caching[match[1]] = match[2], match[3], set()
        elif match := _TLS.search(line):
            why = next((meaning for message, meaning in REASONS if message in match["why"]), "it failed")
            self._connections.reject(f"connection: {why}", f"a connection: {why}")
        elif _STRANGER.search(line):
            self._connections.reject(
                "stranger", "all messages of a client: no role of this run has its certificate's name"
            )

    def _on_denial(self, line: bytes, match: re.Match[bytes]) -> None:
        """Count a denied message, but not a denial that Zenoh only computes in advance for a key."""
        if match["zid"]:
            if len(self._names) >= MAX_NAMES:
                self._names.clear()
            self._names[match["zid"]] = match["name"].decode(errors="replace")
        if match["flow"] == b"egress":
            return  # not a client's action: a wildcard of the world matched a client that may not receive it
        thread = _THREAD.search(line)
        ahead = self._caching.get(thread[1]) if thread and match["zid"] else None
        if ahead is not None and ahead[:2] == (match["flow"], match["key"]) and match["act"] not in ahead[2]:
            ahead[2].add(match["act"])
            return
        name = self._names.get(match["zid"] or match["cached"], "an unknown client")
        act, key = match["act"].decode().lower(), match["key"].decode(errors="replace")
        drops = self._by_role.get(name, self._others)
        drops.reject(f"{name}: {act} on {key}", f"{name}'s {act} on {key}: it has no right to it")


@contextlib.asynccontextmanager
async def running(roles: Iterable[str], logger: logging.Logger) -> AsyncIterator[None]:
    """Context in which the rejections of a run with these `roles` are logged, and at its end their totals."""
    audit = Audit(logger, roles)
    sys.stdout.flush()
    original = os.dup(1)
    read_end, write_end = os.pipe()
    if hasattr(fcntl, "F_SETPIPE_SZ"):
        fcntl.fcntl(read_end, fcntl.F_SETPIPE_SZ, PIPE)
    os.dup2(write_end, 1)
    os.close(write_end)
    os.environ["NO_COLOR"] = "1"
    bus.log(LEVELS)
    reader = threading.Thread(target=_follow, args=(read_end, audit), name="audit", daemon=True)
    reader.start()
    try:
        yield
    finally:
        os.dup2(original, 1)  # closes the pipe's last writer, which ends its reader
        os.close(original)
        reader.join(1.0)
        audit.log_total()


def _follow(pipe: int, audit: Audit) -> None:
    """Feed the audit from the pipe until its writers have closed it."""
    while block := os.read(pipe, PIPE):
        audit.feed(block)
        if len(block) < PIPE // 2:  # a fuller pipe is read again at once: a full one blocks the threads that log
            time.sleep(PAUSE)
    os.close(pipe)
