"""The lockstep on the event loop: observations that are sent again, dropped messages, and ticks without robots."""

import asyncio
import logging
from dataclasses import replace

import numpy as np

from fes.protocol import keys
from fes.protocol.messages import Join
from fes.transport.drop_log import DropLog
from fes.transport.inbox import Inbox
from tests.support.attackers import command
from tests.support.loop import load
from world.execution.hosting import Membership
from world.execution.lifecycle import Lifecycle
from world.server.lockstep import Lockstep
from world.simulation import truth


def running() -> Lifecycle:
    """The life cycles of two robots whose agents are alive."""
    lifecycle = Lifecycle(2, {}, Membership({robot: Join((robot,), robot) for robot in (0, 1)}), 0.0)
    for robot in (0, 1):
        lifecycle.token(robot, alive=True)
    lifecycle.begin_run(resumed=True)
    return lifecycle


def test_the_event_loop_runs_at_every_tick_even_if_no_robot_takes_part() -> None:
    """Otherwise no signal, change or token would be handled while all robots hang by schedule."""

    async def main() -> list[bool]:
        inbox, drops = Inbox(asyncio.get_running_loop()), DropLog(logging.getLogger("test"))
        clock = Lockstep(inbox, running(), drops, [])
        state = truth.start(truth.create(load("pair.toml")))
        ticks = list[bool]()
        asyncio.get_running_loop().call_soon(ticks.append, True)
        await clock.collect(replace(state, present=np.zeros(2, dtype=np.bool_)), [b"", b""])
        return ticks

    assert asyncio.run(main()) == [True]


def test_each_message_has_its_effect_and_errors_are_counted() -> None:
    """Junk, a tick long past, and a second answer; the first answer of each robot is the one that it follows."""

    async def main() -> DropLog:
        inbox, drops = Inbox(asyncio.get_running_loop()), DropLog(logging.getLogger("test"))
        clock = Lockstep(inbox, running(), drops, [])
        state = replace(truth.start(truth.create(load("pair.toml"))), tick=7)
        payloads = [b"junk", command(3, 0), command(7, 0, 2.0), command(7, 0, 3.0)]
        for payload in payloads:
            inbox.put(keys.command("test", 0), payload)
        inbox.put(keys.command("test", 1), command(7, 1))
        answers, present = await clock.collect(state, [b"", b""])
        assert [answer and answer[1] for answer in answers] == [payloads[2], command(7, 1)]
        assert present.tolist() == [True, True]
        return drops

    drops = asyncio.run(main())
    assert drops.counts["Command: is not for this tick"] == 1
    assert drops.counts["Command: came twice"] == 1
    assert sum(drops.counts.values()) == 3


def test_a_robot_that_does_not_answer_gets_its_observation_again() -> None:
    async def main() -> list[bytes]:
        inbox, drops = Inbox(asyncio.get_running_loop()), DropLog(logging.getLogger("test"))
        asked = list[bytes]()

        def ask(payload: bytes) -> None:
            asked.append(payload)
            inbox.put(keys.command("test", 1), command(0, 1))

        clock = Lockstep(inbox, running(), drops, [asked.append, ask])
        inbox.put(keys.command("test", 0), command(0, 0))
        _, present = await clock.collect(truth.start(truth.create(load("pair.toml"))), [b"first", b"second"])
        assert present.tolist() == [True, True]
        return asked

    assert asyncio.run(main()) == [b"second"]
