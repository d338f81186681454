"""The end of a tick in lockstep, also of a tick without robots, and answers that may come twice."""

import asyncio
import logging
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from fes.protocol import keys
from fes.transport.drop_log import DropLog
from fes.transport.inbox import Inbox
from tests.support.attackers import command
from tests.support.clocks import Clock
from tests.support.loop import load
from world.server.lockstep import Lockstep
from world.simulation import truth
from world.simulation.truth import State


def without_robots(pace: float | None) -> tuple[Lockstep, State]:
    """A lockstep, and a world whose two robots do not take part."""
    inbox, drops = Inbox(asyncio.get_running_loop()), DropLog(logging.getLogger("test"))
    clock = Lockstep(inbox, None, drops, lambda robot, payload: None, pace)  # type: ignore[arg-type]
    state = truth.start(truth.create(load("pair.toml")))
    return clock, replace(state, present=np.zeros(2, dtype=np.bool_))


def test_a_lockstep_with_a_pace_ends_each_tick_when_it_is_due_and_catches_up(monkeypatch: pytest.MonkeyPatch) -> None:
    wall = Clock(monkeypatch, "world.server.lockstep", lambda sleep: 0.03 if sleep == 2 else 0.0)

    async def main() -> None:
        clock, state = without_robots(0.02)
        for _ in range(5):
            await clock.collect(state, [b"", b""])

    asyncio.run(main())
    assert wall.slept == pytest.approx([0.02, 0.02, 0.0, 0.01, 0.02])
    assert wall.now == pytest.approx(100.1)  # five ticks, the last one of full length


def test_the_event_loop_runs_at_every_tick_even_if_no_robot_takes_part() -> None:
    """Otherwise no signal, change or token would be handled while all robots hang by schedule."""

    async def main() -> list[bool]:
        (clock, state), ticks = without_robots(None), list[bool]()
        asyncio.get_running_loop().call_soon(ticks.append, True)
        await clock.collect(state, [b"", b""])
        return ticks

    assert asyncio.run(main()) == [True]


def test_second_answers_to_observations_sent_again_in_consecutive_ticks_are_not_errors(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The robot pauses between its answers: the second one comes when the next observation was sent again."""
    monkeypatch.setattr("world.execution.barrier.RESEND_AFTER", 0.01)
    asked: list[int] = []

    async def main() -> DropLog:
        inbox, drops = Inbox(asyncio.get_running_loop()), DropLog(logging.getLogger("test"))
        participation = SimpleNamespace(reachable=np.ones(2, dtype=np.bool_), wake=lambda robot: False)
        state = truth.start(truth.create(load("pair.toml")))

        def answer(tick: int, robot: int) -> None:
            inbox.put(keys.command("test", robot), command(tick, robot))

        def ask(robot: int, payload: bytes) -> None:
            if robot == 0 and int(payload) not in asked:
                asked.append(int(payload))
                if asked[-1] > 0:
                    answer(asked[-1] - 1, 0)  # the second answer, late
                answer(asked[-1], 0)
                answer(asked[-1], 1)

        clock = Lockstep(inbox, participation, drops, ask)  # type: ignore[arg-type]
        for tick in range(4):
            answers, present = await clock.collect(replace(state, tick=tick), [b"%d" % tick] * 2)
            assert [received and received[0].tick for received in answers] == [tick, tick]
            assert present.all()
        answer(1, 0)  # a third answer, without a request
        answer(4, 0)
        answer(4, 1)
        await clock.collect(replace(state, tick=4), [b"4"] * 2)
        return drops

    assert asyncio.run(main()).counts == {"Command: is not for this tick": 1}
    assert asked == [0, 1, 2, 3]
