"""The socket of the relay: it takes datagrams of robots on this machine, and forwards some of them unchanged."""

import asyncio
import contextlib
import socket
from collections.abc import Callable, Iterator

import numpy as np

from fes.arithmetic import draws
from fes.errors import FesError, reason
from world.tabletop.radio.relay import Relay

LONGEST = 1400
"""Longest datagram [bytes]; longer ones are dropped."""

AT_ONCE = 256
"""Largest number of datagrams that are taken at one wake-up, so that the bodies are never late."""

BUFFER = 1 << 20
"""Size of the system's buffers [bytes]; beyond it the system drops datagrams."""

Place = tuple[str, int]
Sender = Callable[[bytes], int | None]
"""The robot that a datagram names as its sender; None if it names none."""


class RadioSocket:
    """A socket in an event loop. It queues nothing itself: a datagram that cannot be sent at once is dropped."""

    def __init__(self, opened: socket.socket, relay: Relay[Place], sender: Sender, seed: int) -> None:
        self._socket, self._relay, self._sender = opened, relay, sender
        self._draws = np.random.Generator(np.random.Philox(key=draws.key(seed, "relay")))
        self.unsent = 0
        """Forwarded datagrams that the system did not take."""

    @property
    def place(self) -> str:
        """The address at which it takes datagrams."""
        host, port = self._socket.getsockname()
        return f"{host}:{port}"

    def read(self) -> None:
        """Forward the datagrams that wait, at most AT_ONCE."""
        for _ in range(AT_ONCE):
            try:
                datagram, address = self._socket.recvfrom(LONGEST + 1)
            except (BlockingIOError, InterruptedError):
                return
            except OSError:
                continue  # an earlier datagram had no receiver: its robot has ended
            self._forward(datagram, address)

    def _forward(self, datagram: bytes, address: Place) -> None:
        sender = self._sender(datagram) if len(datagram) <= LONGEST else None
        numbers = self._draws.random(len(self._relay.sent))
        for receiver in self._relay.receivers(sender, address, numbers):
            try:
                self._socket.sendto(datagram, receiver)
            except OSError:
                self.unsent += 1


@contextlib.contextmanager
def opened(place: Place, relay: Relay[Place], sender: Sender, seed: int) -> Iterator[RadioSocket]:
    """A relay at a `place` of this machine, in the running event loop; raises FesError if the port is taken."""
    loop = asyncio.get_running_loop()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as bound:
        bound.setblocking(False)
        for option in (socket.SO_RCVBUF, socket.SO_SNDBUF):
            bound.setsockopt(socket.SOL_SOCKET, option, BUFFER)
        try:
            bound.bind(place)
        except OSError as error:
            raise FesError(f"--radio {place[0]}:{place[1]}: {reason(error)}") from None
        radio = RadioSocket(bound, relay, sender, seed)
        loop.add_reader(bound.fileno(), radio.read)
        try:
            yield radio
        finally:
            loop.remove_reader(bound.fileno())
