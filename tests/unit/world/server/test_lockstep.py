"""When a tick of the lockstep is over though nobody is waited for, and what answers may come twice."""

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


def of_nobody(pace: float | None) -> tuple[Lockstep, State]:
    """A lockstep, and a world whose two robots do not take part."""
    inbox, drops = Inbox(asyncio.get_running_loop()), DropLog(logging.getLogger("test"))
    clock = Lockstep(inbox, None, drops, lambda robot, payload: None, pace)  # type: ignore[arg-type]
    state = truth.start(truth.create(load("pair.toml")))
    return clock, replace(state, present=np.zeros(2, dtype=np.bool_))


def test_a_lockstep_with_a_pace_ends_each_tick_when_it_is_due_and_catches_up(monkeypatch: pytest.MonkeyPatch) -> None:
    wall = Clock(monkeypatch, "world.server.lockstep", lambda sleep: 0.03 if sleep == 2 else 0.0)

    async def main() -> None:
        clock, state = of_nobody(0.02)
        for _ in range(5):
            await clock.collect(state, [b"", b""])

    asyncio.run(main())
    assert wall.slept == pytest.approx([0.02, 0.02, 0.0, 0.01, 0.02])
    assert wall.now == pytest.approx(100.1)  # five ticks, the last one whole


def test_the_loop_has_its_turn_at_every_tick_though_nobody_takes_part() -> None:
    """Or no signal, change or token would come through while all hang by schedule."""

    async def main() -> list[bool]:
        (clock, state), ticks = of_nobody(None), list[bool]()
        asyncio.get_running_loop().call_soon(ticks.append, True)
        await clock.collect(state, [b"", b""])
        return ticks

    assert asyncio.run(main()) == [True]


def test_second_answers_of_a_robot_that_is_asked_again_in_one_tick_after_the_other_are_no_fault_of_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It stops for a moment between its answers: the second one comes when it was asked again for the next tick."""
    monkeypatch.setattr("world.server.lockstep.RESEND_AFTER", 0.01)
    asked: list[int] = []

    async def main() -> DropLog:
        inbox, drops = Inbox(asyncio.get_running_loop()), DropLog(logging.getLogger("test"))
        everybody = SimpleNamespace(reachable=np.ones(2, dtype=np.bool_), wake=lambda robot: False)
        state = truth.start(truth.create(load("pair.toml")))

        def answer(tick: int, robot: int) -> None:
            inbox.put(keys.command("test", robot), command(tick, robot))

        def ask(robot: int, payload: bytes) -> None:
            if robot == 0 and int(payload) not in asked:
                asked.append(int(payload))
                if asked[-1] > 0:
                    answer(asked[-1] - 1, 0)  # the second one, late
                answer(asked[-1], 0)
                answer(asked[-1], 1)

        clock = Lockstep(inbox, everybody, drops, ask)  # type: ignore[arg-type]
        for tick in range(4):
            answers, present = await clock.collect(replace(state, tick=tick), [b"%d" % tick] * 2)
            assert [found and found[0].tick for found in answers] == [tick, tick]
            assert present.all()
        answer(1, 0)  # nobody asked for a third one
        answer(4, 0)
        answer(4, 1)
        await clock.collect(replace(state, tick=4), [b"4"] * 2)
        return drops

    assert asyncio.run(main()).counts == {"Command: is not for this tick": 1}
    assert asked == [0, 1, 2, 3]
