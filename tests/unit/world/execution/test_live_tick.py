"""The rules of the live clock, tick by tick: held, late and skipped commands, silent robots, and a late world."""

import numpy as np
import pytest

from world.execution.barrier import Participants
from world.execution.live_tick import HANG_TIMEOUT, LivePace, LiveTick, Timing
from world.metrics.deadlines import COMMAND_TIMEOUT

TICK = 0.02  # s
BOTH = np.array([True, True])
STARTED = np.array([0, 0])


def follow(commands: dict[int, list[tuple[int, int]]], ticks: int) -> tuple[list[list[bool]], list[list[bool]]]:
    """For each tick, the robots that follow a command, and the silent ones; `commands` are (robot, tick) by tick."""
    live, following, silent = LiveTick(2, TICK), list[list[bool]](), list[list[bool]]()
    for tick in range(ticks):
        for robot, command_tick in commands.get(tick, []):
            live.receive(command_tick, robot, tick)
        end = live.end(Participants(tick, BOTH, STARTED))
        following.append(end.following.tolist())
        silent.append(end.silent.tolist())
    return following, silent


def test_the_last_command_is_held_until_it_is_too_old_and_then_the_robot_stops() -> None:
    ticks = 40
    always = {tick: [(0, tick)] for tick in range(ticks)}
    always[0].append((1, 0))
    following, silent = follow(always, ticks)
    alive = 13  # ticks for which a command holds: 12 * 20 ms < 250 ms
    assert (alive - 1) * TICK < COMMAND_TIMEOUT <= alive * TICK
    assert [robots[0] for robots in following] == [True] * ticks
    assert [robots[1] for robots in following] == [True] * alive + [False] * (ticks - alive)
    assert not np.any(silent)


def test_a_late_command_is_late_once_and_then_obeyed() -> None:
    live = LiveTick(2, TICK)
    assert [live.receive(0, robot, 0) for robot in (0, 1)] == [Timing.IN_TIME] * 2
    received = [live.receive(*command, 2) for command in ((1, 1), (2, 0), (2, 0), (1, 0), (0, 1))]
    assert received == [Timing.LATE, Timing.IN_TIME, Timing.OLD, Timing.OLD, Timing.OLD]
    assert live.receive(2, 1, 2) is Timing.IN_TIME


def test_a_silent_robot_is_named_when_it_was_silent_for_long_enough() -> None:
    last = round(HANG_TIMEOUT / TICK)
    _, silent = follow({tick: [(0, tick)] for tick in range(last + 1)}, last + 1)
    assert silent == [[False, False]] * last + [[False, True]]


def test_a_command_for_a_future_tick_is_an_error_and_not_followed() -> None:
    live = LiveTick(2, TICK)
    assert live.receive(1, 0, 0) is Timing.FUTURE
    assert live.end(Participants(0, BOTH, STARTED)).following.tolist() == [False, False]
    assert live.end(Participants(1, BOTH, STARTED)).following.tolist() == [False, False]


def test_a_robot_that_rejoined_follows_no_command_from_before_and_is_not_silent_yet() -> None:
    live = LiveTick(2, TICK)
    live.receive(199, 0, 200)
    live.receive(200, 1, 200)
    end = live.end(Participants(200, BOTH, np.array([200, 0])))
    assert end.following.tolist() == [False, True]
    end = live.end(Participants(299, BOTH, np.array([200, 200])))
    assert end.silent.tolist() == [False, False]
    end = live.end(Participants(300, np.array([True, False]), np.array([200, 200])))
    assert (end.following.tolist(), end.silent.tolist()) == ([False, False], [True, False])


def test_the_clock_of_a_late_world_slips_and_gives_every_robot_a_complete_tick() -> None:
    pace, now, rests, slips = LivePace(TICK), 100.0, [], []
    for longer in (0.001, 0.5, 0.001, 0.001):  # the world sleeps longer than requested
        rests.append(pace.rest(now))
        now += rests[-1] + longer
        slips.append(pace.slip(now))
    assert rests == pytest.approx([0.02, 0.019, 0.02, 0.019])
    assert slips == pytest.approx([0.0, 0.5, 0.0, 0.0])
