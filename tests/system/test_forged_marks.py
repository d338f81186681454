"""Forged marks of a configuration: from outside the team over TLS, and from a robot of the team itself."""

import asyncio
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from agents.configuration.exchange import Exchange
from console.backends import inprocess
from console.keys import certificates
from fes.arrays.types import Bytes, Ints
from fes.protocol import keys, messages
from fes.protocol.messages import Beacon
from tests.support import session, team_keys
from tests.support.forgers import run_with_a_forger
from tests.support.loop import load
from tests.support.stage import ROLES, RUN, SECONDS

SET = ("--set", "formation.configuration=lattice")
CREWS = [[0, 2, 3, 4], [1], [5, 6, 7, 8, 9]]


def beacon(tick: int) -> bytes:
    """A forged beacon of robot 0 with a mark 40 m off its place, for the period of the next tick."""
    declared = np.zeros(130, dtype=np.uint8)
    declared[:4] = np.frombuffer(np.uint32(tick // 100).tobytes(), dtype=np.uint8)
    own = np.uint16(0).tobytes() + np.array([0.0, 40.0, 70.0], dtype=np.float32).tobytes()
    empty = np.uint16(65535).tobytes() + bytes(12)
    declared[4:] = np.frombuffer(own + 8 * empty, dtype=np.uint8)
    link, wanted, named, nothing = np.array([1]), np.array([70.0]), np.ones(1, dtype=np.uint8), np.zeros(0)
    return messages.encode_beacon(Beacon(tick, 0, (0.0, 40.0, 0.5), link, wanted, named, nothing, declared.tobytes()))


def expected() -> str:
    return str(
        inprocess.run(load("pair.toml", run__duration=SECONDS, formation__configuration="lattice"), "")["digest"]
    )


def test_marks_forged_from_outside_move_a_team_without_certificates(tmp_path: Path) -> None:
    """The attack works without TLS, which the next test relies on."""
    digest, _ = asyncio.run(run_with_a_forger(tmp_path, None, keys.beacon(RUN, 0), beacon, SET))
    assert digest not in ("", expected())


def test_over_tls_marks_forged_from_outside_are_dropped_and_change_no_digit(tmp_path: Path) -> None:
    keyed, key = team_keys.directory(tmp_path / "keys", certificates.create(1.0), ROLES), keys.beacon(RUN, 0)
    digest, log = asyncio.run(run_with_a_forger(tmp_path, keyed, key, beacon, SET))
    assert digest == expected()
    assert log.count(f"dropped robot-1's put on {key}: it has no right to it") == 1


def summary_with_a_liar(monkeypatch: pytest.MonkeyPatch, seconds: float, shift: float, first: float) -> Any:
    """The summary of a team in which robot 1 relays the marks of others `shift` [m] off, from `first` [s] on.

    In every other beacon it forges them for the next period, ahead of their robots.
    """
    honest, beats = Exchange.send, count()

    def send(self: Exchange, table: Any, epoch: Ints, last: Ints) -> tuple[Bytes, Ints]:
        data, after = honest(self, table, epoch, last)
        if self._own.tolist() == [1] and epoch[0] >= first / 2.0 and next(beats) % 2:
            message = data.view(self._layout)[:, 0].copy()
            message["marks"]["mark"][:, 1:, 0] += np.float32(shift)
            message["epoch"] += np.uint32(1)
            message["marks"]["id"][:, 0] = 65535
            data = message.view(np.uint8).reshape(1, -1)
        return data, after

    monkeypatch.setattr(Exchange, "send", send)
    scenario = load("team-paper-start.toml", run__duration=seconds)
    return session.finished(scenario, CREWS)[0]


def test_marks_that_a_robot_cannot_have_reached_are_refused_from_a_robot_of_the_team(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    summary = summary_with_a_liar(monkeypatch, 12.0, 400.0, 4.0)
    monkeypatch.undo()
    assert summary["smallest_separation"] > 20.0
    assert summary["disk_connected_always"]
    assert summary["digest"] == inprocess.run(load("team-paper-start.toml", run__duration=12.0), "")["digest"]


def test_marks_within_reach_are_believed_and_safe_separation_holds_all_the_same(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """This is not protected: a robot of the team may lead the others astray, by as much as a robot can move."""
    summary = summary_with_a_liar(monkeypatch, 12.0, 8.0, 4.0)
    monkeypatch.undo()
    assert summary["digest"] != inprocess.run(load("team-paper-start.toml", run__duration=12.0), "")["digest"]
    assert summary["smallest_separation"] > 5.0
