"""The rules of the live clock, tick by tick: held, late and skipped commands."""

import asyncio
import logging
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from agents.runtime.outbox import Outbox
from agents.runtime.tick_source import TickSource
from agents.runtime.world_liveliness import WorldLiveliness
from console.backends import inprocess
from console.dashboard import header
from fes.protocol import keys, messages
from fes.protocol.messages import Command, Observation
from fes.protocol.report import decode_report, encode_report
from fes.transport.drop_log import DropLog
from fes.transport.inbox import Inbox
from tests.support.clocks import Clock
from tests.support.frames import a_report
from tests.support.loop import load
from world.metrics import report_builder
from world.metrics.collector import MetricsCollector
from world.metrics.deadlines import COMMAND_TIMEOUT, Deadlines, no_deadlines
from world.server import live
from world.server.live import WARM_UP, LiveClock
from world.server.lockstep import Lockstep
from world.simulation import truth
from world.simulation.truth import State

NOTHING = np.zeros(0, dtype=np.int64)
TICK = 0.02  # s


def command(robot: int, tick: int, speed: float = 1.0) -> bytes:
    return messages.encode_command(Command(tick, robot, (speed, 0.0), NOTHING, np.zeros(0), np.zeros(0)))


class StubParticipation:
    """Participation that notes the calls to it."""

    def __init__(self) -> None:
        self.silent: list[list[int]] = []
        self.heard: list[int] = []

    def hang(self, silent: Any) -> None:
        self.silent.append(np.flatnonzero(silent).tolist())

    def wake(self, robot: int) -> bool:
        self.heard.append(robot)
        return False


def world_of_two() -> tuple[State, Deadlines, StubParticipation]:
    world = truth.create(load("pair.toml", run__clock="live"))
    return truth.start(world), no_deadlines(2), StubParticipation()


def warm(participation: Any, deadlines: Deadlines) -> tuple[Inbox, LiveClock]:
    """The inbox of a live clock, and the clock, whose ticks in lockstep are over."""
    inbox, drops = Inbox(asyncio.get_running_loop()), DropLog(logging.getLogger("test"))
    lockstep = Lockstep(inbox, participation, drops, lambda robot, payload: None)
    clock = LiveClock(lockstep, inbox, participation, drops, deadlines, TICK)
    clock._left = 0
    return inbox, clock


def spoken(commands: dict[int, list[bytes]], ticks: int) -> tuple[list[list[int]], Deadlines, StubParticipation]:
    """Per tick: the tick of the command that each of two robots follows, -1 for none; `said` are commands by tick."""
    state, deadlines, participation = world_of_two()
    result: list[list[int]] = []

    async def main() -> None:
        inbox, clock = warm(participation, deadlines)
        clock._end_of_tick = lambda: asyncio.sleep(0)  # type: ignore[method-assign]
        for tick in range(ticks):
            for payload in commands.get(tick, []):
                inbox.put(keys.command("test", messages.decode_command(payload).robot), payload)
            now = replace(state, tick=tick)
            answers, present = await clock.collect(now, [b"", b""])
            assert present.all()
            ticks_of = np.array([answer[0].tick if answer else -1 for answer in answers])
            deadlines.add(tick, now.present, ticks_of)
            result.append(ticks_of.tolist())

    asyncio.run(main())
    return result, deadlines, participation


class WarmUp:
    """A lockstep in which only robot 0 answers."""

    def __init__(self) -> None:
        self.ticks: list[int] = []

    async def collect(self, state: State, sent: list[bytes]) -> Any:
        self.ticks.append(state.tick)
        payload = command(0, state.tick)
        return [(messages.decode_command(payload), payload), None], np.array([True, False])


def test_the_first_ticks_of_a_live_clock_are_in_lockstep_and_their_last_command_is_held() -> None:
    state, deadlines, participation = world_of_two()
    warm_up = WarmUp()

    async def main() -> list[tuple[list[int], list[bool]]]:
        inbox, drops = Inbox(asyncio.get_running_loop()), DropLog(logging.getLogger("test"))
        clock = LiveClock(warm_up, inbox, participation, drops, deadlines, TICK)  # type: ignore[arg-type]
        result = []
        for tick in range(7, 7 + WARM_UP + 1):  # a resumed world warms up, too
            answers, present = await clock.collect(replace(state, tick=tick), [b"", b""])
            result.append(([answer[0].tick if answer else -1 for answer in answers], present.tolist()))
        return result

    *warm, live_one = asyncio.run(main())
    assert warm_up.ticks == list(range(7, 7 + WARM_UP))
    assert warm == [([tick, -1], [True, False]) for tick in warm_up.ticks]
    assert live_one == ([warm_up.ticks[-1], -1], [True, True])


def test_the_last_command_is_held_until_it_is_too_old_and_then_the_robot_stops() -> None:
    ticks = 40
    always = {tick: [command(0, tick)] for tick in range(ticks)}
    always[0].append(command(1, 0))
    result, deadlines, participation = spoken(always, ticks)
    alive = round(COMMAND_TIMEOUT / TICK + 0.4999)  # ticks for which a command holds
    assert [robots[0] for robots in result] == list(range(ticks))
    assert [robots[1] for robots in result] == [0] * alive + [-1] * (ticks - alive)
    assert deadlines.due.tolist() == [ticks, ticks]
    assert deadlines.missed.tolist() == [0, ticks - 1]
    assert deadlines.stopped.tolist() == [0, ticks - alive]
    assert deadlines.late.tolist() == [0, 0]
    assert participation.silent == []


def test_a_late_command_is_counted_once_and_then_obeyed() -> None:
    commands = {
        0: [command(0, 0), command(1, 0)],
        1: [command(0, 1)],
        2: [command(1, 1), command(0, 2), command(0, 2), command(0, 1)],  # late, in time, and again
        3: [command(0, 3), command(1, 3)],
    }
    result, deadlines, _ = spoken(commands, 4)
    assert result == [[0, 0], [1, 0], [2, 1], [3, 3]]
    assert deadlines.missed.tolist() == [0, 2]
    assert deadlines.late.tolist() == [0, 1]
    assert deadlines.table()["missed_share"] == 2 / 8


def test_a_silent_robot_is_excluded() -> None:
    ticks = round(live.HANG_TIMEOUT / TICK) + 1
    _, _, participation = spoken({tick: [command(0, tick)] for tick in range(ticks)}, ticks)
    assert participation.silent == [[1]]


def test_a_command_for_a_future_tick_is_rejected() -> None:
    result, deadlines, _ = spoken({0: [command(0, 1), command(1, 0)]}, 2)
    assert result == [[-1, 0], [-1, 0]]
    assert deadlines.late.tolist() == [0, 0]


def test_an_agent_answers_the_newest_tick_and_counts_those_it_skipped() -> None:
    async def main() -> tuple[list[int], TickSource]:
        loop = asyncio.get_running_loop()
        inbox = Inbox(loop)
        ticks = TickSource((0, 1), inbox, Outbox.__new__(Outbox), DropLog(logging.getLogger("test")))
        world = WorldLiveliness("the world", inbox)

        def sense(robot: int, tick: int, since: int = 0, over: bool = False) -> None:
            sensed = Observation(tick, robot, (0.0, 0.0, 0.0), NOTHING, NOTHING.astype(np.uint8), over, since)
            inbox.put(keys.observation("test", robot), messages.encode_observation(sensed))

        answered = []
        for tick in (0, 1, 2):
            sense(0, tick)
        sense(1, 0)
        sense(1, 1)  # robot 1's observation of tick 2 is on its way
        async for observations in ticks.live(world):
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


def test_the_clock_of_a_late_world_slips_and_gives_every_robot_a_complete_tick(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    _, deadlines, participation = world_of_two()
    wall = Clock(monkeypatch, "world.server.live", lambda sleep: 0.5 if sleep == 2 else 0.001)

    async def main() -> None:
        _, clock = warm(participation, deadlines)
        for _ in range(4):
            await clock._end_of_tick()

    asyncio.run(main())
    assert wall.slept == pytest.approx([0.02, 0.019, 0.02, 0.019])
    assert deadlines.slipped == pytest.approx(0.5)


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
