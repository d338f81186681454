"""A run of two robots with well-formed forgeries on every tick: the run differs, but not over TLS."""

import asyncio
import re
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest
import zenoh

from console.backends import inprocess
from console.keys import certificates
from fes.model.sensing import DECODED
from fes.protocol import keys, messages
from fes.protocol.messages import Beacon, Command, Observation
from fes.transport.bus import Bus
from tests.support import team_keys
from tests.support.loop import load
from tests.support.stage import ROLES, RUN, SECONDS, stage


def command(tick: int) -> bytes:
    """A forged observation that dismisses robot 0."""
    no_peers, nothing = np.zeros(0, dtype=np.int64), np.zeros(0)
    return messages.encode_command(Command(tick, 0, (5.0, 1.0), no_peers, nothing, nothing))


def beacon(tick: int) -> bytes:
    """A forged beacon of robot 0, with another position and separation."""
    named = np.ones(1, dtype=np.uint8)
    link, wanted, nothing = np.array([1]), np.array([140.0]), np.zeros(0)
    return messages.encode_beacon(Beacon(tick, 0, (0.0, 60.0, 0.5), link, wanted, named, nothing))


def observation(tick: int) -> bytes:
    """A forged observation with another pose of robot 0."""
    near, decoded = np.array([1]), np.full(1, DECODED, dtype=np.uint8)
    return messages.encode_observation(Observation(tick, 0, (0.0, 60.0, 0.5), near, decoded, over=False, since=0))


FORGERIES: dict[str, Callable[[int], bytes]] = {
    keys.command(RUN, 0): command,
    keys.beacon(RUN, 0): beacon,
    keys.observation(RUN, 0): observation,
}


async def forge(attacker: Bus, key: str, forged: Callable[[int], bytes], is_over: Callable[[], bool]) -> int:
    """Publish on `key` the `forged` message of the next tick until the run is over; return the number of ticks seen.

    Robot 1 marks the time: it receives only the world, and the programs that the world authorizes.
    """
    marks = [b""]  # without TLS any program can overhear the mark of an agent's commands

    def overhear(sample: zenoh.Sample) -> None:
        marks[0] = sample.attachment.to_bytes() if sample.attachment is not None else b""

    callback = zenoh.handlers.Callback(overhear, indirect=False)
    listening = attacker._session.declare_subscriber(keys.command(RUN, 0), callback)
    clock, ticks = attacker.mailbox(keys.beacon(RUN, 1)), set[int]()
    while not is_over():
        while (heard := clock.take()) is not None:
            assert heard[1] is not None
            ticks.add(messages.decode_beacon(heard[1]).tick)
        if ticks:
            attacker._session.put(key, forged(max(ticks) + 1), attachment=marks[0])
        await asyncio.sleep(0.001)
    listening.undeclare()
    return len(ticks)


async def run_with_a_forger(
    where: Path, keyed: Path | None, key: str, forged: Callable[[int], bytes], words: Sequence[str] = ()
) -> tuple[str, str]:
    """Digest and log of a run in which robot 1, or without TLS any client, impersonates robot 0."""
    async with stage(where, keyed, words) as world, world.visitor("robot-1") as attacker:
        world.agent(0)
        world.agent(1)
        over = asyncio.ensure_future(world.over())
        ticks = await forge(attacker, key, forged, over.done)
        good = await over
        if keyed:  # without TLS it may end the run early, on a slow machine
            assert good, world.log()
            assert ticks > 10
        return world.digest(), world.log()


@pytest.fixture
def expected() -> str:
    return str(inprocess.run(load("pair.toml", run__duration=SECONDS), "pair")["digest"])


@pytest.mark.parametrize("key", FORGERIES)
def test_forgeries_change_a_run_without_certificates(tmp_path: Path, expected: str, key: str) -> None:
    """The attack works without TLS, which the next test relies on."""
    digest, _ = asyncio.run(run_with_a_forger(tmp_path, None, key, FORGERIES[key]))
    assert digest not in ("", expected)


@pytest.mark.parametrize("key", FORGERIES)
def test_forgeries_are_dropped_logged_once_and_change_no_digit(tmp_path: Path, expected: str, key: str) -> None:
    keyed = team_keys.directory(tmp_path / "keys", certificates.create(1.0), ROLES)
    digest, log = asyncio.run(run_with_a_forger(tmp_path, keyed, key, FORGERIES[key]))
    assert digest == expected
    assert log.count(f"dropped robot-1's put on {key}: it has no right to it") == 1
    [often] = re.findall(rf"dropped messages: robot-1: put on {key} x(\d+)", log)
    assert int(often) > 10
