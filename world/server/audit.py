"""Who was turned away: Zenoh's own log, read for refused connections and denied messages, one line a kind.

Zenoh drops what access control denies and tells neither side; only its log, at the finest level, speaks of it.
That goes to the process's standard output, which the world has no use for: so a pipe is put in its place.
The hot path is the search of a block of the log for what it may hold; see docs/security.md for the cost.
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
"""Bytes that the log may be ahead of its reader."""

PAUSE = 0.05
"""The reader looks so often [s]: more often it would hold up the world's own thread."""

KINDS_OF_ONE = 20
"""Kinds that are told apart for one name on a certificate: nobody can fill the log, or hide another."""

MAX_NAMES = 10_000
"""Sessions whose names are remembered."""

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
"""What Zenoh says of a connection that failed, and what it means."""


class Audit:
    """What was turned away, by kind; fed with the log as it comes."""

    def __init__(self, logger: logging.Logger, roles: Iterable[str]) -> None:
        """For a run that has these `roles`; whoever else is named, even by a forged line, is one of the others."""
        self._connections, self._others = DropLog(logger), DropLog(logger, KINDS_OF_ONE)
        self._by_role = {role: DropLog(logger, KINDS_OF_ONE, f"{role}: other") for role in roles}
        self._rest = b""
        self._names: dict[bytes, str] = {}
        self._caching: dict[bytes, tuple[bytes, bytes, set[bytes]]] = {}
        """By thread, what it computes ahead: flow, key, and actions that would be denied."""

    @property
    def counts(self) -> Counter[str]:
        """How often what was turned away."""
        return sum((each.counts for each in self._each()), Counter[str]())

    def log_total(self) -> None:
        """A line for each who was turned away."""
        for each in self._each():
            each.log_total()

    def _each(self) -> list[DropLog]:
        return [self._connections, *self._by_role.values(), self._others]

    def feed(self, block: bytes) -> None:
        """Read a block of the log, which may begin and end amid a line."""
        whole, newline, rest = (self._rest + block).rpartition(b"\n")
        self._rest = rest[-PIPE:]
        if newline and any(mark in whole for mark in _MARKS):
            for line in whole.split(b"\n"):
                self._read(line)

    def _read(self, line: bytes) -> None:
        if found := _DENIED.search(line):
            self._on_denial(line, found)
        elif found := _CACHING.search(line):
            self._caching[found[1]] = found[2], found[3], set()
        elif found := _TLS.search(line):
            why = next((meaning for said, meaning in REASONS if said in found["why"]), "it failed")
            self._connections.reject(f"connection: {why}", f"a connection: {why}")
        elif found := _STRANGER.search(line):
            self._connections.reject(
                "stranger", "all that a client says: no role of this run has its certificate's name"
            )

    def _on_denial(self, line: bytes, found: re.Match[bytes]) -> None:
        """A message that was denied, or, while Zenoh computes ahead what a key permits, one that would be."""
        if found["zid"]:
            if len(self._names) >= MAX_NAMES:
                self._names.clear()
            self._names[found["zid"]] = found["name"].decode(errors="replace")
        if found["flow"] == b"egress":
            return  # nobody did anything: a wildcard of the world's reaches somebody it does not concern
        thread = _THREAD.search(line)
        ahead = self._caching.get(thread[1]) if thread and found["zid"] else None
        if ahead is not None and ahead[:2] == (found["flow"], found["key"]) and found["act"] not in ahead[2]:
            ahead[2].add(found["act"])
            return
        who = self._names.get(found["zid"] or found["cached"], "somebody")
        act, key = found["act"].decode().lower(), found["key"].decode(errors="replace")
        drops = self._by_role.get(who, self._others)
        drops.reject(f"{who}: {act} on {key}", f"{who}'s {act} on {key}: it has no right to it")


@contextlib.asynccontextmanager
async def kept(roles: Iterable[str]) -> AsyncIterator[None]:
    """Log what is turned away from a run of these `roles` while the block lasts, and at its end how often."""
    audit = Audit(logging.getLogger("world"), roles)
    sys.stdout.flush()
    original = os.dup(1)
    out, into = os.pipe()
    if hasattr(fcntl, "F_SETPIPE_SZ"):
        fcntl.fcntl(out, fcntl.F_SETPIPE_SZ, PIPE)
    os.dup2(into, 1)
    os.close(into)
    os.environ["NO_COLOR"] = "1"
    bus.log(LEVELS)
    reader = threading.Thread(target=_follow, args=(out, audit), name="audit", daemon=True)
    reader.start()
    try:
        yield
    finally:
        os.dup2(original, 1)  # the pipe's last writer is gone, which ends its reader
        os.close(original)
        reader.join(1.0)
        audit.log_total()


def _follow(pipe: int, audit: Audit) -> None:
    """Feed the audit with what comes through the pipe, to its end."""
    while block := os.read(pipe, PIPE):
        audit.feed(block)
        if len(block) < PIPE // 2:  # else the log comes faster than it is read, and would hold up its writers
            time.sleep(PAUSE)
    os.close(pipe)
