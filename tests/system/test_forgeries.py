"""A run of two robots with well-formed forgeries on every tick: the run differs, but not over TLS."""

import asyncio
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from console.backends import inprocess
from console.keys import certificates
from fes.model.sensing import DECODED
from fes.protocol import keys, messages
from fes.protocol.messages import Beacon, Command, Observation
from tests.support import team_keys
from tests.support.forgers import run_with_a_forger
from tests.support.loop import load
from tests.support.stage import ROLES, RUN, SECONDS


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
