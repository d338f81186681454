"""The UDP socket of a robot's beacons: multicast, or the same datagrams to and from a relay by unicast.

The system stamps each datagram as it arrives. So a robot can read them all at once, at its own tick, and need not
wake for each of them.

A multicast frame is sent once, is not acknowledged and not repeated. So a lost beacon is a loss of the channel, and
the robots can count it. Zenoh would repeat it, or drop it for reasons of its own.
"""

import asyncio
import contextlib
import secrets
import socket
import struct
import time
from collections.abc import Callable
from typing import Self

from fes.errors import FesError, MessageError, TransportError, reason
from fes.protocol import sealed
from fes.protocol.sealed import Sealed
from field.radio import wall_clock
from field.radio.counters import RadioCounters
from field.radio.replay_window import ReplayWindow
from field.radio.settings import RadioSettings

OnBeacon = Callable[[Sealed, int], None]
"""Takes a beacon, and the time of its arrival [ns, CLOCK_MONOTONIC]."""

BUFFER = 1 << 20
"""Wanted size of the receive buffer [bytes]; the system may allow less."""

AT_ONCE = 4096
"""Largest number of datagrams that one call reads: a flood does not hold up the robot."""

SAME_ROBOT = "a robot must not have two processes"

_IP_MULTICAST_ALL = 49  # Linux's number, which Python does not name
_SO_RXQ_OVFL = 40
_SO_TIMESTAMPNS = 35
_COUNT = struct.Struct("=I")
_STAMP = struct.Struct("=qq")
_ROOM = socket.CMSG_SPACE(_COUNT.size) + socket.CMSG_SPACE(_STAMP.size)
_MEMBERSHIP = struct.Struct("=4s4si")  # struct ip_mreqn: group, address, index of the interface


class Radio:
    """A robot's radio, to be closed at the end of a `with` block."""

    def __init__(
        self, opened: socket.socket, settings: RadioSettings, run: str, robot: int, on_beacon: OnBeacon
    ) -> None:
        self.counters = RadioCounters()
        self.boot = secrets.randbits(64)
        """The number of this start."""
        self._socket, self._run, self._robot, self._key = opened, run, robot, settings.key
        self._to = None if settings.relay else (settings.group, settings.port)
        self._on_beacon, self._window, self._sequence = on_beacon, ReplayWindow(), 0
        self._loop, self._since = asyncio.get_running_loop(), time.monotonic_ns()  # no datagram arrives before

    @classmethod
    async def opened(cls, settings: RadioSettings, run: str, robot: int, on_beacon: OnBeacon) -> "Radio":
        """The radio of a robot in a run; raises TransportError for a network that it cannot use.

        A radio with a relay sends an empty payload at once, so that the relay knows its address. Receivers ignore it.
        """
        if settings.relay:
            radio = cls(await _connected(settings.relay), settings, run, robot, on_beacon)
            radio.send(b"")
            return radio
        return cls(_member(settings), settings, run, robot, on_beacon)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def fileno(self) -> int:
        """The number of the socket, for a loop that is to wake when a datagram arrives."""
        return self._socket.fileno()

    def close(self) -> None:
        """Stop receiving."""
        if self._socket.fileno() >= 0:
            self._loop.remove_reader(self._socket)
            self._socket.close()

    def send(self, payload: bytes) -> bool:
        """Send a payload once; True if the system took it. A payload that was not taken has no number.

        Raises MessageError for a payload that is too long.
        """
        datagram = sealed.seal(self._key, self._run, self._robot, self.boot, self._sequence, payload)
        try:
            if self._to is None:
                self._socket.send(datagram)
            else:
                self._socket.sendto(datagram, self._to)
        except OSError:  # it does not wait: the next beacon is worth more
            self.counters.unsent += 1
            return False
        self._sequence += 1
        self.counters.sent += 1
        return True

    def receive(self) -> None:
        """Read the datagrams that have arrived, up to AT_ONCE of them, and hand on those that pass.

        The time of an arrival is that of the system where it is known, else that of this call.
        """
        ahead = wall_clock.ahead()
        called = time.monotonic_ns()
        for _ in range(AT_ONCE):
            try:
                datagram, extra, _, _ = self._socket.recvmsg(sealed.LONGEST + 1, _ROOM)
            except BlockingIOError:
                self._since = max(self._since, called)  # all that was there is read
                return
            except OSError:  # the relay did not listen to what was sent before: it may later
                continue
            arrived = now = time.monotonic_ns()
            for level, kind, data in extra:
                if level == socket.SOL_SOCKET and kind == _SO_RXQ_OVFL:
                    self.counters.overflowed = _COUNT.unpack(data[: _COUNT.size])[0]
                elif level == socket.SOL_SOCKET and kind == _SO_TIMESTAMPNS and len(data) >= _STAMP.size:
                    seconds, nanoseconds = _STAMP.unpack(data[: _STAMP.size])
                    # the wall clock may have jumped since
                    arrived = min(max(seconds * 1_000_000_000 + nanoseconds - ahead, self._since), now)
            self._since = arrived  # the next datagram was behind it in the queue
            self._take(datagram, arrived)

    def _take(self, datagram: bytes, arrived: int) -> None:
        """Hand on a datagram, or count the rule that it breaks."""
        counters = self.counters
        try:
            message = sealed.opened(self._key, self._run, datagram)
        except MessageError as error:
            counters.refused[error.rule] += 1
            return
        if message.robot == self._robot:
            if message.boot == self.boot:
                counters.own += 1
            else:
                counters.refused[SAME_ROBOT] += 1
            return
        if rule := self._window.refusal(message.robot, message.boot, message.sequence, arrived):
            counters.refused[rule] += 1
        elif message.payload:
            counters.heard += 1
            self._on_beacon(message, arrived)


def _member(settings: RadioSettings) -> socket.socket:
    """A socket in the group; its TTL keeps the beacons in the network of its interface."""
    where = f"radio group {settings.group}:{settings.port}" + f" on {settings.interface}" * bool(settings.interface)
    opened = _socket(socket.AF_INET)
    try:
        group = socket.inet_aton(settings.group)
        index = socket.if_nametoindex(settings.interface) if settings.interface else 0
        member = _MEMBERSHIP.pack(group, bytes(4), index)
        opened.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)  # robots of one machine share the port
        opened.bind((settings.group, settings.port))  # not to any address: datagrams to other groups stay out
        opened.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, member)
        opened.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, member)
        opened.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 1)
        opened.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_LOOP, 1)
        # without it, Linux also hands over what other processes' memberships receive on other interfaces
        opened.setsockopt(socket.IPPROTO_IP, _IP_MULTICAST_ALL, 0)
    except OSError as error:
        opened.close()
        raise TransportError(f"{where}: {reason(error)}") from None
    return opened


async def _connected(relay: str) -> socket.socket:
    """A socket that exchanges datagrams with a relay alone."""
    host, _, port = relay.rpartition(":")
    if not host or not port.isdecimal() or not 0 < int(port) < 1 << 16:
        raise FesError(f"a relay must be host:port, got: {relay}")
    try:
        addresses = await asyncio.get_running_loop().getaddrinfo(host.strip("[]"), port, type=socket.SOCK_DGRAM)
        family, _, _, _, address = addresses[0]
        opened = _socket(family)
    except OSError as error:
        raise TransportError(f"radio relay {relay}: {reason(error)}") from None
    try:
        opened.connect(address)
    except OSError as error:
        opened.close()
        raise TransportError(f"radio relay {relay}: {reason(error)}") from None
    return opened


def _socket(family: int) -> socket.socket:
    """A UDP socket that never blocks, and states when each datagram arrived and how many were dropped before it."""
    opened = socket.socket(family, socket.SOCK_DGRAM)
    opened.setblocking(False)
    opened.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, BUFFER)
    for option in (_SO_RXQ_OVFL, _SO_TIMESTAMPNS):
        with contextlib.suppress(OSError):  # Linux has them
            opened.setsockopt(socket.SOL_SOCKET, option, 1)
    return opened
