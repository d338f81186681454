"""The gate on real Zenoh sessions, with a body that speaks ROS 2 bytes in both styles of keys."""

import asyncio
from collections.abc import Awaitable, Callable
from itertools import pairwise
from typing import Any

import pytest

from fes.errors import Rejected
from fes.protocol.robot_control import HELD, RUNNING, STOPPED
from fes.ros import graph, topics
from fes.ros.messages import write_twist
from fes.transport import foreign
from field.gate.rules import gate as rules
from field.gate.rules.settings import Timing, TopicSettings
from tests.support.gate_stage import PATIENT, Stage, driving, gate, settings, stage, until
from tests.support.processes import PATIENCE
from tests.support.session import client

STYLES = ("ros2dds", "rmw_zenoh")


def run(main: Callable[[], Awaitable[None]]) -> None:
    async def bounded() -> None:
        async with asyncio.timeout(PATIENCE):
            await main()

    asyncio.run(bounded())


async def start(on: Stage) -> None:
    """Start the robot as soon as its gate has a pose and a permit."""
    while not await on.operator.has_started():
        await asyncio.sleep(0.01)


@pytest.mark.parametrize("style", STYLES)
@pytest.mark.parametrize("command", ["Twist", "TwistStamped"])
@pytest.mark.parametrize("pose", ["Odometry", "PoseStamped"])
def test_a_robot_moves_after_its_start_and_stands_after_a_stop(style: str, command: str, pose: str) -> None:
    async def main() -> None:
        names = {"pose": ("robot3/pose", pose), "command": ("robot3/cmd_vel", command)}
        parts: dict[str, Any] = {name: TopicSettings(*words) for name, words in names.items()}
        async with stage(style=style, domain=7, **parts) as on, gate(on.settings) as link, driving(link, 0.1):
            await until(lambda: link.pose is not None)
            assert on.body.received == []  # nothing before the first start
            await start(on)
            await on.speed(lambda linear: linear >= 0.1)
            assert (await on.operator.status()).mode == RUNNING
            stopped = await on.operator.stop()
            assert (stopped.mode, stopped.reason) == (STOPPED, "stopped by the operator")
            await on.speed(lambda linear: linear == 0.0)
            length = len(on.body.received)
            await until(lambda: len(on.body.received) > length + 10)  # it commands zero while it is stopped
            assert {received.linear for received in on.body.received[length:]} == {0.0}
            marks = [topics.read_attachment(mark) for mark in on.body.attachments]
            numbers = [mark.sequence for mark in marks if mark is not None]
            assert numbers == sorted(set(numbers))  # a congested network drops some
            assert len(numbers) == (len(marks) if style == "rmw_zenoh" else 0)
            assert min(numbers, default=1) >= 1

    run(main)


def test_the_agent_gets_the_poses_in_the_team_frame_and_the_state_of_its_gate() -> None:
    async def main() -> None:
        async with stage() as on, gate(on.settings) as link, driving(link, 0.1):
            await start(on)
            await until(lambda: link.progress is not None and link.progress.mode == RUNNING)
            await until(lambda: link.pose is not None and link.pose.pose[0] > 0.01)
            poses = link.take()
            assert len(poses) > 5
            assert all(first.received_at <= second.received_at for first, second in pairwise(poses))
            await on.operator.stop()
            await until(lambda: link.progress is not None and link.progress.reason == "stopped by the operator")

    run(main)


@pytest.mark.parametrize("style", STYLES)
def test_a_second_driver_stops_the_robot(style: str) -> None:
    async def main() -> None:
        async with stage(style=style) as on, gate(on.settings) as link, driving(link, 0.1):
            await start(on)
            await on.speed(lambda linear: linear >= 0.1)
            async with client(on.endpoint) as second:
                put = foreign.declare_publisher(second, topics.publish_key(on.settings.body.command_topic))
                put(write_twist("Twist", 0.0, 0.0), b"")
                assert (await on.reason(STOPPED)).startswith("another program commands the body on ")

    run(main)


def test_a_start_is_refused_while_a_node_that_publishes_commands_is_alive() -> None:
    async def main() -> None:
        async with stage(style="rmw_zenoh") as on, client(on.endpoint) as second:
            topic = on.settings.body.command_topic
            node = graph.Node(str(second.session.zid()), "teleop", "/robot3")
            second.declare_token(graph.publisher_token(node, topic, 1))
            async with gate(on.settings) as link:
                await until(lambda: link.pose is not None)
                with pytest.raises(Rejected, match="another program can command the body: /robot3/teleop"):
                    await on.operator.start()

    run(main)


def test_the_gate_shows_in_the_graph_of_ros() -> None:
    async def main() -> None:
        async with stage(style="rmw_zenoh") as on, gate(on.settings), client(on.endpoint) as observer:
            pattern = graph.publishers(on.settings.body.command_topic)
            endpoints = [graph.parse_token(token) for token in await observer.liveliness_get(pattern, PATIENCE)]
            assert [(end.node, end.type) for end in endpoints if end] == [("/fes_gate", "Twist")]

    run(main)


async def change_frame(on: Stage) -> None:
    on.body.frame = "odom"


async def change_type(on: Stage) -> None:
    on.body.pose_type = "PoseStamped"


async def jump(on: Stage) -> None:
    on.body.shift = 5.0


async def leave(on: Stage) -> None:
    await on.operator.leave()


CAUSES = {
    "frame": (change_frame, "the pose must be in frame 'map', got 'odom'"),
    "type": (change_type, "no pose of the body: Odometry: "),
    "jump": (jump, "the pose jumps by "),
    "permit": (leave, "the operator's permit has lapsed"),
}


@pytest.mark.parametrize("style", STYLES)
@pytest.mark.parametrize("cause", CAUSES)
def test_a_cause_of_the_table_stops_the_robot_and_it_stays_stopped(cause: str, style: str) -> None:
    disturb, reason = CAUSES[cause]

    async def main() -> None:
        async with stage(style=style) as on, gate(on.settings) as link, driving(link, 0.1):
            await start(on)
            await on.speed(lambda linear: linear >= 0.1)
            await disturb(on)
            assert (await on.reason(STOPPED)).startswith(reason)
            await on.speed(lambda linear: linear == 0.0)
            on.operator.hold()
            length = len(on.body.received)
            await until(lambda: len(on.body.received) > length + 10)
            assert on.body.linear == 0.0
            assert (await on.operator.status()).reason.startswith(reason)

    run(main)


def test_a_body_without_power_is_stopped_by_the_check_of_its_motion() -> None:
    async def main() -> None:
        async with stage(Timing(lateness=0.5, timeout=0.5, pose_age=1.0, permit=3.0)) as on:
            on.body.gain = 0.0
            async with gate(on.settings) as link, driving(link, 0.2):
                await start(on)
                assert await on.reason(STOPPED) == "the pose travels 0 times as far as commanded within 2 s"

    run(main)


def test_a_robot_is_held_while_its_body_is_silent_and_then_resumes() -> None:
    async def main() -> None:
        async with stage() as on, gate(on.settings) as link, driving(link, 0.1):
            await start(on)
            await on.speed(lambda linear: linear >= 0.1)
            on.body.is_silent = True
            assert await on.reason(HELD) == "no fresh pose for 1 s"
            await on.speed(lambda linear: linear == 0.0)
            on.body.is_silent = False
            await on.speed(lambda linear: linear >= 0.1)

    run(main)


def test_a_robot_is_held_while_its_agent_is_silent_and_then_resumes() -> None:
    async def main() -> None:
        async with stage() as on, gate(on.settings) as link:
            await start(on)
            async with driving(link, 0.1):
                await on.speed(lambda linear: linear >= 0.1)
            assert await on.reason(HELD) == "no command from the agent for 0.5 s"
            await on.speed(lambda linear: linear == 0.0)
            async with driving(link, -0.1):
                await on.speed(lambda linear: linear <= -0.1)

    run(main)


def test_a_second_gate_of_a_robot_is_refused_and_the_first_one_stays() -> None:
    async def main() -> None:
        async with stage() as on, gate(on.settings) as link, driving(link, 0.1):
            await start(on)
            with pytest.raises(Rejected, match="a robot has one gate, and that of robot 3 in run 'test' is alive"):
                async with gate(settings(on.endpoint)):
                    pass
            await on.speed(lambda linear: linear >= 0.1)
            assert (await on.operator.status()).mode == RUNNING

    run(main)


def test_an_error_in_the_gate_itself_ends_it_with_zeros(monkeypatch: pytest.MonkeyPatch) -> None:
    async def fail(on: Stage) -> None:
        async with gate(on.settings) as link, driving(link, 0.1):
            await start(on)
            await on.speed(lambda linear: linear >= 0.1)
            monkeypatch.setattr(rules, "updated", lambda *words: 1 / 0)
            await on.speed(lambda linear: linear == 0.0)

    async def main() -> None:
        async with stage() as on:
            with pytest.raises(ZeroDivisionError):
                await fail(on)
            await until(lambda: [twist.linear for twist in on.body.received[-5:]] == [0.0] * 5)

    run(main)


def test_the_end_of_the_agent_ends_the_gate_with_zeros() -> None:
    async def main() -> None:
        async with stage() as on:
            async with gate(on.settings) as link, driving(link, 0.1):
                await start(on)
                await on.speed(lambda linear: linear >= 0.1)
            await until(lambda: [twist.linear for twist in on.body.received[-5:]] == [0.0] * 5)
            steps = [twist.linear for twist in on.body.received]
            limit = on.settings.limits.acceleration * (PATIENT.period + PATIENT.lateness) + 1e-9
            assert max(abs(second - first) for first, second in pairwise(steps)) <= limit

    run(main)
