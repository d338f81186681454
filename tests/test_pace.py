"""When a tick of the lockstep is over though nobody is waited for."""

import asyncio
import logging
from dataclasses import replace

import numpy as np
import pytest

from fes.complaints import Complaints
from fes.inbox import Inbox
from tests.clocks import Clock
from tests.loop import load
from world import simulation
from world.lockstep import Lockstep
from world.simulation import State


def of_nobody(pace: float | None) -> tuple[Lockstep, State]:
    """A lockstep, and a world whose two robots do not take part."""
    inbox, complaints = Inbox(asyncio.get_running_loop()), Complaints(logging.getLogger("test"))
    clock = Lockstep(inbox, None, complaints, lambda robot, payload: None, pace)  # type: ignore[arg-type]
    state = simulation.start(simulation.create(load("pair.toml")))
    return clock, replace(state, present=np.zeros(2, dtype=np.bool_))


def test_a_lockstep_with_a_pace_ends_each_tick_when_it_is_due_and_catches_up(monkeypatch: pytest.MonkeyPatch) -> None:
    wall = Clock(monkeypatch, "world.lockstep", lambda sleep: 0.03 if sleep == 2 else 0.0)

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
        (clock, state), turns = of_nobody(None), list[bool]()
        asyncio.get_running_loop().call_soon(turns.append, True)
        await clock.collect(state, [b"", b""])
        return turns

    assert asyncio.run(main()) == [True]
