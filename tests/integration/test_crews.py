"""Robots that share a process join and leave together, whichever of their tokens appears or is lost."""

import asyncio
from collections import defaultdict
from pathlib import Path
from typing import Any

import pytest

from agents.process import Agent
from agents.runtime.outbox import Outbox
from console.replay import command as replay_command
from console.replay import log
from fes.protocol import keys
from fes.transport.bus import Bus
from tests.support import session
from tests.support.loop import load
from tests.support.rejoining import live_through, standing_still, until
from world.config.scenario import Scenario
from world.server.server import Server

GROUPS = [[0, 1], [2]]
"""A crew of two robots, and a robot that is never disturbed."""


def three() -> Scenario:
    poses = [[0.0, 0.0, 0.5], [60.0, 0.0, 2.0], [120.0, 0.0, 1.0]]
    return load("pair.toml", robots__poses=poses, run__duration=4.0)


def attendances(path: Path) -> list[tuple[int, list[list[int]]]]:
    """Each tick at which participation changed, and the robots that take part from then on."""
    return [(tick.number, tick.attended) for tick in log.load(path).ticks() if tick.attended]


def test_a_crew_leaves_with_its_first_token_and_rejoins_with_its_last(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tokens, declare = defaultdict[int, list[Any]](list), Bus.declare_token
    held, holding = list[tuple[Bus, str]](), asyncio.Event()

    def token(opened: Bus, key: str) -> None:
        robot = keys.robot_of(key)
        if holding.is_set() and robot == 1:
            held.append((opened, key))
            return
        declare(opened, key)
        if robot is not None:
            tokens[robot].append(opened._held[-1])

    monkeypatch.setattr(Bus, "declare_token", token)

    async def story(server: Server, agents: list["asyncio.Task[Agent]"], endpoint: str) -> None:
        await until(server, lambda state: state.tick >= 20)
        tokens[1][0].undeclare()  # robot 0's token stays
        gone = await until(server, lambda state: not state.present[1])
        await until(server, lambda state: state.tick >= gone + 5)
        assert server.lifecycle.hosting.alive.tolist() == [1, 0, 1]
        assert server.run.state.present.tolist() == [False, False, True]
        agents[0].cancel()
        async with standing_still(server):
            while server.lifecycle.hosting.alive[0]:
                await asyncio.sleep(0.01)
            holding.set()
            agents[0] = asyncio.ensure_future(session.live(endpoint, [0, 1]))
            while not (server.lifecycle.hosting.alive[0] and held):
                await asyncio.sleep(0.01)
        half = server.run.state.tick  # the token of robot 0 is alive, that of robot 1 will follow
        await until(server, lambda state: state.tick >= half + 20)
        assert server.run.state.present.tolist() == [False, False, True]
        async with standing_still(server):
            declare(*held[0])
            while not server.lifecycle.hosting.alive[1]:
                await asyncio.sleep(0.01)
        await until(server, lambda state: state.present.all())

    path = tmp_path / "run.mcap"
    summary = live_through(three(), path, story, groups=GROUPS)
    assert summary["ticks"] == 200
    assert [present for _, present in attendances(path)] == [[[2]], [[0, 1, 2]]]
    assert replay_command.rerun(log.load(path), all_robots=True)["digest"] == summary["digest"]


def test_a_crew_with_a_silent_robot_is_excluded_until_that_robot_answers(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    mute, say, repeat = asyncio.Event(), Outbox.publish, Outbox.resend
    unsaid: list[tuple[Outbox, int, Any]] = []

    def half_said(outbox: Outbox, tick: int, answers: Any) -> None:
        if mute.is_set() and answers[0][0] == 0:
            unsaid.append((outbox, tick, answers[1:]))
            answers = answers[:1]
        say(outbox, tick, answers)

    monkeypatch.setattr(Outbox, "publish", half_said)
    monkeypatch.setattr(Outbox, "resend", lambda *asked: None if mute.is_set() else repeat(*asked))

    async def story(server: Server, agents: Any, endpoint: str) -> None:
        await until(server, lambda state: state.tick >= 20)
        mute.set()
        with monkeypatch.context() as impatient:
            impatient.setattr("world.execution.barrier.ANSWER_TIMEOUT", 1.0)
            gone = await until(server, lambda state: not state.present[1])
        await until(server, lambda state: state.tick >= gone + 20)
        assert server.run.state.present.tolist() == [False, False, True]
        assert server.lifecycle.hosting.hosted.all()  # all tokens are alive
        async with standing_still(server):
            mute.clear()
            for late in unsaid:
                say(*late)
            while not (server._inbox._items or server.lifecycle.reachable[1]):
                await asyncio.sleep(0.01)
        await until(server, lambda state: state.present.all())

    path = tmp_path / "run.mcap"
    summary = live_through(three(), path, story, groups=GROUPS)
    assert len(unsaid) == 1
    logged = [line for line in caplog.messages if "does not answer" in line]
    assert logged == [
        "robot 1 does not answer"
    ]  # the world did not wait for robot 0, which could not answer without robot 1
    assert summary["ticks"] == 200
    (silent, first), (left, then), (_, back) = attendances(path)
    # Robot 0 answered the tick at which the world waited.
    assert (first, then, back) == ([[0, 2]], [[2]], [[0, 1, 2]])
    assert left == silent + 1
    assert replay_command.rerun(log.load(path), all_robots=True)["digest"] == summary["digest"]
