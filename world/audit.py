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
import threading
from collections.abc import Iterator

from fes import bus
from fes.complaints import Complaints

LEVELS = "off,zenoh::net::routing::interceptor::access_control=trace,zenoh_link_tls=warn"
PIPE = 1 << 20
"""Bytes that the log may be ahead of its reader."""

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

    def __init__(self, complaints: Complaints) -> None:
        self._complaints = complaints
        self._rest = b""
        self._names: dict[bytes, str] = {}
        self._caching: dict[bytes, tuple[bytes, bytes, set[bytes]]] = {}
