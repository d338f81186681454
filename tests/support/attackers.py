"""Attackers of a run, and the run under attack."""

import asyncio
import contextlib
import functools
import struct
from collections.abc import Callable, Iterator
from typing import Any
from unittest import mock

import msgpack
import numpy as np

from agents.process import Agent
from console.backends import inprocess
from fes.errors import Rejected
from fes.protocol import keys, messages, wire
from fes.protocol.messages import Beacon, Command, Join, Observation
from fes.transport.bus import Bus
from tests.support import session
from tests.support.loop import load
from tests.support.processes import PATIENCE
from tests.support.session import RUN
from world.server.server import Server

ROBOTS = 10
FLOOD = 10_000
NO_PEERS = np.zeros(0, dtype=np.int64)
NOTHING = np.zeros(0)

AGENT = 4711
"""Number of every agent of an attacked run, so that attackers know the mark of its commands."""
MARK = Join((0,), AGENT).mark

Attack = Callable[[Bus], Iterator[tuple[str, bytes]]]


@functools.cache
def undisturbed() -> str:
    """Digest of the attacked run without an attack."""
    return str(inprocess.run(load("paper.toml", run__duration=2.0), "test")["digest"])


def attacked(disturb: Any) -> tuple[Server, list[Agent]]:
    """World and agents of a disturbed run; it must have the digest of an undisturbed one."""

    async def bounded() -> Any:
        async with asyncio.timeout(60.0):
            scenario = load("paper.toml", run__duration=2.0)
            with mock.patch("agents.runtime.membership.secrets.randbelow", return_value=AGENT):
                return await session.run(scenario, [[robot] for robot in range(ROBOTS)], disturb)

    summary, server, agents = asyncio.run(bounded())
    assert summary["digest"] == undisturbed()
    return server, agents


def put(attacker: Bus, key: str, payload: bytes) -> None:
    """Put a payload with the mark that the agents of the run use."""
    attacker._session.put(key, payload, attachment=MARK)


async def ticks_go_by(opened: Bus, count: int, begin: asyncio.Event | None = None) -> None:
    """Wait until robot 0 has answered `count` more ticks; set `begin` once its answers can be seen."""
    loop, done, seen = asyncio.get_running_loop(), asyncio.Event(), set[bytes]()

    def on_command(key: str, payload: bytes | None) -> None:
        seen.add(payload or b"")
        if len(seen) > count:  # the first may have been sent before we subscribed
            loop.call_soon_threadsafe(done.set)

    undeclare = opened.declare_subscriber(keys.command(RUN, 0), on_command)
    if begin is not None:
        await arrived(opened)
        begin.set()
    await done.wait()
    undeclare()


async def arrived(opened: Bus) -> None:
    """Wait until earlier declarations and puts have reached world and robots: queries take the same route."""
    await opened.get(keys.about(RUN), b"", PATIENCE)
    for robot in range(ROBOTS):
        with contextlib.suppress(Rejected):
            await opened.get(keys.recall(RUN, robot), messages.encode_recall(10**9), PATIENCE)


def everywhere(payload: bytes, run: str = RUN) -> list[tuple[str, bytes]]:
    """A payload for every key that has a subscriber."""
    robots = [key(run, robot) for robot in range(ROBOTS) for key in (keys.beacon, keys.command, keys.observation)]
    return [(key, payload) for key in [*robots, keys.report(run), keys.welcome(run, "2-3"), keys.change(run)]]


def command(tick: int, robot: int, linear: float = 1.0) -> bytes:
    return messages.encode_command(Command(tick, robot, (linear, 1.0), NO_PEERS, NOTHING, NOTHING))


def beacon(tick: int, robot: int) -> bytes:
    return messages.encode_beacon(
        Beacon(tick, robot, (1.0, 2.0, 3.0), NO_PEERS, NOTHING, NO_PEERS.astype(np.uint8), NOTHING)
    )


def observation(tick: int, robot: int) -> bytes:
    nothing = NO_PEERS.astype(np.uint8)
    return messages.encode_observation(
        Observation(tick, robot, (9.0, 9.0, 9.0), NO_PEERS, nothing, over=False, since=0)
    )


def reversioned(payload: bytes) -> bytes:
    return msgpack.packb([1, *msgpack.unpackb(payload)[1:]])  # type: ignore[no-any-return]


NAN = struct.pack(">d", float("nan"))
BAD_PAYLOADS = {
    "junk": (b"\xc1 junk", "Command: is not msgpack (FormatError)"),
    "empty": (b"", "Command: is not msgpack (ValueError)"),
    "another protocol version": (reversioned(command(5, 3)), f"Command: {wire.WRONG_VERSION}"),
    "not a number": (command(5, 3).replace(struct.pack(">d", 1.0), NAN), "Command: expects a finite number"),
    "a mebibyte of zeros": (bytes(wire.MAX_PAYLOAD - 200), "Command: is not msgpack (ExtraData)"),
    "a tick long past": (command(0, 3), "Command: came on another robot's key"),
}
