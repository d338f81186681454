"""A wall clock that jumps by an hour under a real robot: it drives on without a jerk, stops, and its log is whole.

A C library, which the processes load first, moves their wall clocks. The body's truth keeps its own time.
"""

import asyncio
import json
import os
import signal
from pathlib import Path
from typing import Any

import pytest

from console.team import gates
from fes.protocol.robot_control import HELD, RUNNING, STOPPED
from tests.support.commands import call
from tests.support.jumped_clock import JumpedClock, needs_compiler
from tests.support.processes import PATIENCE
from tests.support.robot_table import (
    LINEAR,
    PERIOD,
    RUN,
    TRUTH_PERIOD,
    Stage,
    bound,
    is_running,
    moving,
    now,
    run,
    stage,
)

HOUR = 3600
AGES = 1.0
"""Longest of the ages that the gate judges [s]: long for a busy machine, short beside an hour."""

WATCHED = 3 * AGES
"""Time for which the robot is watched after each jump [s]."""

TURN = 0.5
"""Angular velocity of a robot that cruises [rad/s]."""

pytestmark = needs_compiler


def patient(tables: dict[str, dict[str, Any]]) -> None:
    """Limits for a busy machine."""
    tables["limits"] |= {"command_timeout": AGES, "command_age": AGES / 2, "pose_age": AGES, "lateness": AGES}
    tables["limits"] |= {"permit_timeout": 5 * AGES, "motion_check": 0.0}


async def later(on: Stage, event: float) -> None:
    """Wait until the truth tells of the whole time that is watched after an event."""
    async with asyncio.timeout(PATIENCE):
        while on.truth()[-1]["monotonic"] < event + WATCHED:
            await asyncio.sleep(TRUTH_PERIOD)


def check_no_jerk(on: Stage, event: float) -> None:
    """The body has driven only as the law commands, or slower: never backward, faster, or along another curve."""
    lines = [line for line in on.truth() if line["monotonic"] >= event - 2 * TRUTH_PERIOD]
    assert len(lines) > WATCHED / TRUTH_PERIOD / 2
    for line in lines:
        linear, angular = line["twists"][0]
        assert -1e-9 <= linear <= LINEAR + 1e-9
        assert -1e-9 <= angular <= TURN + 1e-9
    assert on.travel(event) <= LINEAR * (lines[-1]["monotonic"] - event + 4 * TRUTH_PERIOD)


@pytest.mark.parametrize("seconds", [HOUR, -HOUR])
def test_a_robot_drives_on_when_the_clock_of_agent_or_gate_jumps_and_still_stops(
    tmp_path: Path, seconds: int
) -> None:
    clock = JumpedClock(tmp_path)

    async def main() -> None:
        async with stage(tmp_path, patient, clock.environment) as on:
            async with moving(on):
                for kinds in (("agent",), ("gate",), ("agent", "gate")):
                    event = now()
                    clock.jump(0, "agent", "gate")
                    clock.jump(seconds, *kinds)
                    await later(on, event)
                    await is_running(on)  # without another start: no stop has come
                    check_no_jerk(on, event)
                event = now()
                await gates.stop(on.session, RUN, [0])
                assert await on.stands(event) <= bound(0.0)
                assert "operator" in (await on.mode(STOPPED)).reason
            os.kill(on.robot.pid, signal.SIGTERM)
            assert await asyncio.to_thread(on.robot.wait, PATIENCE) == 0

    run(main)
    done = call(tmp_path, "fes", "replay", "robot-0.mcap", "--json", "--use", "tests.support.cruise")
    assert (done.returncode, done.stderr) == (0, "the robot ended early: it was stopped\n")
    assert json.loads(done.stdout)["ticks"] > WATCHED / PERIOD / 2  # a busy machine skips ticks


def test_a_drivers_clock_that_is_set_back_holds_the_robot_with_one_line(tmp_path: Path) -> None:
    clock = JumpedClock(tmp_path)

    async def main() -> None:
        async with stage(tmp_path, patient, clock.environment) as on, moving(on):
            event = now()
            clock.jump(HOUR, "table")
            await later(on, event)
            await is_running(on)
            check_no_jerk(on, event)
            event = now()
            clock.jump(-HOUR, "table")  # the stamps of its poses go back: a recording could have started again
            assert await on.stands(event) <= bound(AGES)
            held = await on.mode(HELD)
            assert held.reason == "no fresh pose for 1 s"
            clock.jump(HOUR + 60, "table")
            await on.mode(RUNNING)

    run(main)
