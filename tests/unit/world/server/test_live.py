"""The live clock on the event loop: held, late and skipped commands."""

import asyncio
import logging
from dataclasses import replace
from typing import Any

import numpy as np

from agents.runtime.outbox import Outbox
from agents.runtime.tick_source import TickSource
from agents.runtime.world_liveliness import WorldLiveliness
from console.backends import inprocess
from console.dashboard import header
from fes.protocol import keys, messages
from fes.protocol.messages import Command, Join, Observation
from fes.protocol.report import decode_report, encode_report
from fes.transport.drop_log import DropLog
from fes.transport.inbox import Inbox, ThreadInbox
from tests.support import jumping_clock
from tests.support.frames import a_report
from tests.support.loop import load
from world.execution.hosting import Membership
from world.execution.lifecycle import Lifecycle
from world.execution.live_tick import HANG_TIMEOUT
from world.metrics import report_builder
from world.metrics.collector import MetricsCollector
from world.metrics.deadlines import COMMAND_TIMEOUT, no_deadlines
from world.server.live import WARM_UP, LiveClock
from world.simulation import truth
from world.simulation.truth import State

NOTHING = np.zeros(0, dtype=np.int64)
TICK = 0.02  # s


def command(robot: int, tick: int, speed: float = 1.0) -> bytes:
    return messages.encode_command(Command(tick, robot, (speed, 0.0), NOTHING, np.zeros(0), np.zeros(0)))


def lifecycle_of_two() -> Lifecycle:
    """Two robots whose agents are alive."""
    lifecycle = Lifecycle(2, {}, Membership({robot: Join((robot,), robot) for robot in (0, 1)}), 0.0)
    for robot in (0, 1):
        lifecycle.token(robot, alive=True)
    return lifecycle


class WarmUp:
    """A lockstep in which only robot 0 answers."""

    def __init__(self) -> None:
        self.ticks: list[int] = []

    async def collect(self, state: State, sent: list[bytes]) -> Any:
        self.ticks.append(state.tick)
        payload = command(0, state.tick)
        return [(messages.decode_command(payload), payload), None], np.array([True, False])


def test_the_first_ticks_of_a_live_clock_are_in_lockstep_and_their_last_command_is_held() -> None:
    state = truth.start(truth.create(load("pair.toml", run__clock="live")))
    warm_up = WarmUp()

    async def main() -> list[tuple[list[int], list[bool]]]:
        inbox, drops = Inbox(asyncio.get_running_loop()), DropLog(logging.getLogger("test"))
        clock = LiveClock(warm_up, inbox, lifecycle_of_two(), drops, no_deadlines(2), TICK)  # type: ignore[arg-type]
        result = []
        for tick in range(7, 7 + WARM_UP + 1):  # a resumed world warms up, too
            answers, present = await clock.collect(replace(state, tick=tick), [b"", b""])
            result.append(([answer[0].tick if answer else -1 for answer in answers], present.tolist()))
        return result

    *warm, live_one = jumping_clock.run(main())
    assert warm_up.ticks == list(range(7, 7 + WARM_UP))
    assert warm == [([tick, -1], [True, False]) for tick in warm_up.ticks]
    assert live_one == ([warm_up.ticks[-1], -1], [True, True])


def test_late_and_missed_commands_are_counted_and_silent_robots_excluded() -> None:
    """Robot 0 answers each tick; robot 1 answers tick 0 in time and tick 1 late, and then no more."""
    state, deadlines, lifecycle = truth.start(truth.create(load("pair.toml"))), no_deadlines(2), lifecycle_of_two()
    first, last = 100, 100 + round(HANG_TIMEOUT / TICK) + 1
    commands = {tick: [command(0, tick)] for tick in range(first, last + 1)}
    commands[first].append(command(1, first))
    commands[first + 2] += [command(1, first + 1), command(0, first + 1), command(1, first + 9)]

    async def main() -> DropLog:
        inbox, drops = Inbox(asyncio.get_running_loop()), DropLog(logging.getLogger("test"))
        clock = LiveClock(WarmUp(), inbox, lifecycle, drops, deadlines, TICK)  # type: ignore[arg-type]
        for tick in range(WARM_UP):
            await clock.collect(replace(state, tick=tick), [b"", b""])
        for tick in range(first, last + 1):
            assert lifecycle.reachable.tolist() == [True, True]
            for payload in commands[tick]:
                inbox.put(keys.command("test", messages.decode_command(payload).robot), payload)
            now = replace(state, tick=tick)
            answers, present = await clock.collect(now, [b"", b""])
            assert present.all()
            ticks_of = np.array([answer[0].tick if answer else -1 for answer in answers])
            deadlines.add(tick, now.present, ticks_of)
        return drops

    drops = jumping_clock.run(main())
    ticks = last - first + 1
    held = round(COMMAND_TIMEOUT / TICK + 0.4999)  # ticks for which the command of tick 1 holds
    assert deadlines.due.tolist() == [ticks, ticks]
    assert deadlines.late.tolist() == [0, 1]
    assert deadlines.missed.tolist() == [0, ticks - 1]
    assert deadlines.stopped.tolist() == [0, ticks - 1 - held]
    assert deadlines.table()["missed_share"] == (ticks - 1) / (2 * ticks)
    assert drops.counts == {"Command: is not for this tick": 1}
    assert lifecycle.reachable.tolist() == [True, False]


def test_an_agent_answers_the_newest_tick_and_counts_those_it_skipped() -> None:
    async def main() -> tuple[list[int], TickSource]:
        inbox = ThreadInbox()
        ticks = TickSource("test", (0, 1), inbox, Outbox.__new__(Outbox), DropLog(logging.getLogger("test")))
        world = WorldLiveliness("the world", inbox)

        def sense(robot: int, tick: int, since: int = 0, over: bool = False) -> None:
            sensed = Observation(tick, robot, (0.0, 0.0, 0.0), NOTHING, NOTHING.astype(np.uint8), over, since)
            inbox.put(keys.observation("test", robot), messages.encode_observation(sensed))

        answered = []
        for tick in (0, 1, 2):
            sense(0, tick)
        sense(1, 0)
        sense(1, 1)  # robot 1's observation of tick 2 is on its way
        for observations in ticks.live(world):
            assert {observation.tick for observation in observations} == {ticks.tick}
            answered.append(ticks.tick)
            if ticks.tick == 1:
                for tick in (2, 3, 4, 5):
                    sense(1, tick)
                    sense(0, tick)
            elif ticks.tick == 5:
                for robot in (0, 1):
                    sense(robot, 900, since=900)  # the robots were absent: no tick was skipped
            elif ticks.tick == 900:
                sense(0, 901, over=True)
        return answered, ticks

    answered, ticks = asyncio.run(main())
    assert answered == [1, 5, 900]
    assert ticks.skipped == 3


class SilentBus:
    """A bus without subscribers."""

    def declare_publisher(self, key: str, schema: str, mark: bytes | None = None) -> Any:
        return lambda payload: None

    def declare_queryable(self, key: str, handler: Any) -> None: ...


def test_an_outbox_whose_agent_skips_ticks_still_forgets_old_ones() -> None:
    outbox = Outbox(SilentBus(), "test", (0,), DropLog(logging.getLogger("test")))  # type: ignore[arg-type]
    for tick in range(0, 3000, 3):
        outbox.publish(tick, [(0, b"beacon", b"command")])
    assert len(outbox._commands) <= 2
    assert len(outbox._beacons) <= 2


def test_a_report_counts_missed_and_late_commands_until_its_tick() -> None:
    metrics = MetricsCollector(load("pair.toml", run__clock="live"))
    for tick in inprocess.ticks(load("pair.toml", run__duration=0.1)):
        metrics.add(tick.state, tick.twists, tick.telemetry, np.array([tick.state.tick, 1]))
    assert metrics.deadlines is not None
    metrics.deadlines.late[1] = 2
    report = report_builder.build(metrics, "test", np.ones(2, dtype=np.uint8), 0.0, 0.0)
    decoded = decode_report(encode_report(report))
    assert decoded.missed.tolist() == [0, 3]  # from tick 2 to 4
    assert decoded.late.tolist() == [0, 2]


def test_the_dashboard_shows_missed_commands_per_robot() -> None:
    report = a_report([(0.0, 0.0), (1.0, 0.0)], missed=np.array([1, 4]), late=np.array([0, 3]))
    shown = "".join(text for text, *_ in header.header(report, 120)[1])
    assert "live, deadlines missed 5, 22.73%, robot 1 4" in shown
    assert "late 3" in shown
