"""A real robot stands after any failure of its agent, its body, its network and its operator, within its bound.

The robot cruises at full speed on a table whose driver holds its last command forever, unless a test says otherwise.
"""

import asyncio
import os
import signal
from pathlib import Path
from typing import Any

from console.team import gates, permit
from fes.protocol.robot_control import HELD, STOPPED
from fes.ros import messages
from fes.ros.topics import Topic, publish_key
from fes.transport import foreign
from tests.support.robot_table import RUN, bound, ended, is_running, moving, now, run, stage

TIMEOUT, PERMIT = 0.25, 1.0
"""Times after which the gate notices a missing command and a missing permit [s]."""

SCALE, FENCE = 100.0, 0.35
"""Meters of the truth per meter of the body, and the border ahead of the robot [m; of the body]."""

CUT = 3.0
"""Length of a cut [s]: the commands of this time wait in the link."""


def test_a_robot_whose_agent_is_killed_stands(tmp_path: Path) -> None:
    async def main() -> None:
        async with stage(tmp_path) as on, moving(on):
            event = now()
            os.kill(on.robot.pid, signal.SIGKILL)
            assert await on.stands(event) <= bound(TIMEOUT)

    run(main)


def test_a_robot_whose_agent_is_frozen_stands_and_nothing_that_waited_moves_it(tmp_path: Path) -> None:
    async def main() -> None:
        async with stage(tmp_path) as on, moving(on):
            event = now()
            os.kill(on.robot.pid, signal.SIGSTOP)
            assert await on.stands(event) <= bound(TIMEOUT)
            await gates.stop(on.session, RUN, [0])
            stood = now()
            os.kill(on.robot.pid, signal.SIGCONT)
            await on.mode(STOPPED)
            assert await on.stands(stood) == 0.0

    run(main)


def test_a_frozen_agent_that_continues_drives_again_by_itself(tmp_path: Path) -> None:
    async def main() -> None:
        async with stage(tmp_path) as on, moving(on):
            os.kill(on.robot.pid, signal.SIGSTOP)
            await on.mode(HELD, "no command")
            os.kill(on.robot.pid, signal.SIGCONT)
            await is_running(on)

    run(main)


def test_a_body_that_froze_while_its_agent_died_stands_when_it_continues(tmp_path: Path) -> None:
    async def main() -> None:
        async with stage(tmp_path) as on, moving(on):
            os.kill(on.table.pid, signal.SIGSTOP)
            await on.says("held: no fresh pose")
            gate = on.gate
            os.kill(on.robot.pid, signal.SIGKILL)
            await ended(gate)
            event = now()
            os.kill(on.table.pid, signal.SIGCONT)
            assert await on.stands(event) <= bound(0.0)

    run(main)


def test_a_stop_while_moving_stands_within_the_braking_distance(tmp_path: Path) -> None:
    async def main() -> None:
        async with stage(tmp_path) as on, moving(on):
            event = now()
            await gates.stop(on.session, RUN, [0])
            assert await on.stands(event) <= bound(0.0)
            status = await on.mode(STOPPED)
            assert "operator" in status.reason

    run(main)


def test_a_robot_whose_permit_lapses_stands_and_does_not_drive_again_by_itself(tmp_path: Path) -> None:
    async def main() -> None:
        async with stage(tmp_path) as on:
            async with moving(on):
                event = now()
            assert await on.stands(event) <= bound(PERMIT)
            async with permit.held(on.session, RUN):
                status = await on.mode(STOPPED, "permit")
                assert status.twist == (0.0, 0.0)

    run(main)


def test_nothing_computed_before_a_cut_of_the_drivers_link_moves_the_robot_after_it(tmp_path: Path) -> None:
    async def main() -> None:
        async with stage(tmp_path, driver_timeout=TIMEOUT) as on, moving(on):
            event = now()
            on.link.hold()
            assert await on.stands(event) <= bound(TIMEOUT)
            await asyncio.gather(gates.stop(on.session, RUN, [0]), asyncio.sleep(CUT))
            healed = now()
            on.link.heal()
            assert await on.stands(healed) == 0.0
            await on.mode(STOPPED)

    run(main)


def test_a_robot_that_drives_at_its_fence_stands_before_it(tmp_path: Path) -> None:
    async def main() -> None:
        async with stage(tmp_path, change=_fence) as on, permit.held(on.session, RUN):
            assert gates.is_started((await gates.start(on.session, RUN, [0]))[0])
            status = await on.mode(STOPPED, "the fence is within the braking distance")
            assert status.reason.count("\n") == 0
            await on.stands(now())
            xs = [line["poses"][0][0] / SCALE for line in on.truth()]
            assert max(xs) < FENCE  # its circle has a radius of 0.4 m

    run(main)


def _fence(tables: dict[str, dict[str, Any]]) -> None:
    tables["limits"]["fence"] = [[-1.0, -1.0], [FENCE, -1.0], [FENCE, 1.0], [-1.0, 1.0]]


def test_a_second_program_that_drives_the_robot_stops_it_in_one_line(tmp_path: Path) -> None:
    async def main() -> None:
        async with stage(tmp_path) as on, moving(on):
            put = foreign.declare_publisher(on.session, publish_key(Topic("ros2dds", "robot0/cmd_vel", "Twist")))
            event = now()
            put(messages.write_twist("Twist", 0.1, 0.0), b"")
            status = await on.mode(STOPPED, "another program commands the body")
            assert status.reason.count("\n") == 0
            assert await on.stands(event) <= bound(TIMEOUT)

    run(main)


def test_a_driver_of_another_command_type_is_detected_by_the_pose_that_does_not_move(tmp_path: Path) -> None:
    async def main() -> None:
        async with (
            stage(tmp_path, command_type="TwistStamped", change=_wrong_type) as on,
            permit.held(on.session, RUN),
        ):
            await gates.start(on.session, RUN, [0])
            await on.mode(STOPPED, "as commanded")

    run(main)


def _wrong_type(tables: dict[str, dict[str, dict[str, str]]]) -> None:
    tables["body"]["command"]["type"] = "Twist"


def test_a_wrong_frame_is_refused_in_one_line(tmp_path: Path) -> None:
    async def main() -> None:
        async with stage(tmp_path, frame="odom", change=_common_frame) as on, permit.held(on.session, RUN):
            refusal = str((await gates.start(on.session, RUN, [0]))[0])
            assert "odom" in refusal
            assert "map" in refusal
            assert (await on.mode(STOPPED)).twist == (0.0, 0.0)

    run(main)


def _common_frame(tables: dict[str, dict[str, dict[str, str]]]) -> None:
    tables["body"]["pose"]["frame"] = "map"
