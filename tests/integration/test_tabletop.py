"""A table with robots on real sessions and sockets of this machine: its drivers, and the relay of its radio."""

import asyncio
import itertools
import math
import socket
import time
from collections.abc import Awaitable, Callable
from functools import partial
from typing import Any

import numpy as np
import pytest

from fes.errors import FesError
from fes.protocol import sealed
from fes.ros import graph, messages, topics
from fes.ros.topics import Topic
from fes.transport import foreign
from tests.support import loop
from tests.support.processes import PATIENCE
from tests.support.tables import Gate, command, table, until
from world.tabletop.process import Tabletop
from world.tabletop.radio import radio_socket
from world.tabletop.radio.radio_socket import Place
from world.tabletop.radio.reachability import Reachability
from world.tabletop.radio.relay import Relay

STYLES = pytest.mark.parametrize(
    "settings",
    [
        {"style": "ros2dds", "pose_type": "Odometry", "command_type": "Twist"},
        {"style": "rmw_zenoh", "pose_type": "PoseStamped", "command_type": "TwistStamped", "domain": 7},
        {"style": "rmw_zenoh", "pose_type": "PoseWithCovarianceStamped", "command_type": "Twist"},
    ],
    ids=lambda settings: f"{settings['style']}-{settings['pose_type']}",
)


def run(main: Callable[[], Awaitable[None]]) -> None:
    async def bounded() -> None:
        async with asyncio.timeout(PATIENCE):
            await main()

    asyncio.run(bounded())


@STYLES
def test_a_body_drives_as_it_is_commanded_and_reports_its_pose(settings: dict[str, Any]) -> None:
    async def main() -> None:
        async with table(**settings) as (running, outside):
            gate = Gate(outside, running.config, 6)
            await until(lambda: gate.poses)
            first = gate.poses[0]
            assert (first.x, first.y, first.heading) == pytest.approx((2.25, 0.0, 1.05))  # at 1:100
            assert first.frame == "map"
            await command(running, gate, 0.2, 0.0)
            await until(lambda: math.hypot(gate.poses[-1].x - 2.25, gate.poses[-1].y) > 0.05)
            last = gate.poses[-1]
            assert math.atan2(last.y, last.x - 2.25) == pytest.approx(1.05)  # straight ahead
            await command(running, gate, 0.0, 1.0)
            await until(lambda: gate.poses[-1].heading > 1.15)
            stamps = [pose.stamp for pose in gate.poses]
            assert stamps == sorted(set(stamps))

    run(main)


@pytest.mark.parametrize("style", ["ros2dds", "rmw_zenoh"])
def test_reports_have_the_keys_and_attachments_of_their_style(style: str) -> None:
    async def main() -> None:
        async with table(style=style) as (running, outside):
            gate = Gate(outside, running.config, 3)
            await until(lambda: len(gate.poses) > 5)
            marks = [topics.read_attachment(mark) for mark in gate.marks]
            if style == "ros2dds":
                assert set(gate.keys) == {"robot3/odom"}
                assert set(gate.marks) == {b""}
                return
            assert {key.rpartition("/")[0] for key in gate.keys} == {"0/robot3/odom/nav_msgs::msg::dds_::Odometry_"}
            numbers = [mark.sequence for mark in marks if mark]
            assert numbers == list(range(numbers[0], numbers[0] + len(marks)))
            assert len({mark.gid for mark in marks if mark}) == 1

    run(main)


def test_ten_drivers_of_rmw_zenoh_show_in_the_graph_and_bridges_leave_theirs_to_the_bridge() -> None:
    async def main() -> None:
        async with table(style="rmw_zenoh") as (_, outside):
            tokens = [graph.parse_token(key) for key in await outside.liveliness_get("@ros2_lv/**", PATIENCE)]
            ends = {(end.kind, end.topic, end.type) for end in tokens if end is not None}
            for robot in range(10):
                assert (graph.PUBLISHER, f"/robot{robot}/odom", "Odometry") in ends
                assert (graph.SUBSCRIBER, f"/robot{robot}/cmd_vel", "Twist") in ends
        async with table(style="ros2dds") as (_, outside):
            assert await outside.liveliness_get("@ros2_lv/**", PATIENCE) == []

    run(main)


@pytest.mark.parametrize("style", ["ros2dds", "rmw_zenoh"])
def test_a_command_of_another_type_moves_no_body(style: str) -> None:
    async def main() -> None:
        async with table(style=style) as (running, outside):
            drivers, gate = running.drivers, Gate(outside, running.config, 0)
            assert drivers is not None
            other = Topic(running.config.style, "/robot0/cmd_vel", "TwistStamped")
            put = foreign.declare_publisher(outside, topics.publish_key(other))
            await command(running, gate, 0.0, 0.0)

            def send() -> int:
                put(
                    messages.write_twist("TwistStamped", 0.2, 0.0),
                    topics.attachment(other, next(numbers), 0, bytes(16)),
                )
                return drivers.ignored

            numbers = itertools.count(1)
            if style == "ros2dds":
                await until(lambda: send() >= 5)  # a busy network may drop some
            else:
                for _ in range(5):
                    send()
            await command(running, gate, 0.0, 0.1)
            assert style == "ros2dds" or drivers.ignored == 0  # another type has another key in the style rmw_zenoh
            await until(lambda: gate.poses and gate.poses[-1].heading > gate.poses[0].heading)
            assert (gate.poses[-1].x, gate.poses[-1].y) == (0.0, 0.0)

    run(main)


def test_a_driver_without_a_timeout_drives_on_and_one_with_a_timeout_stops() -> None:
    async def main() -> None:
        async with table(driver_timeout=0.2) as (running, outside):
            gate = Gate(outside, running.config, 0)
            await until(lambda: gate.poses)
            await command(running, gate, 0.1, 0.0)
            await until(lambda: gate.poses[-1].twist == (0.1, 0.0))
            await until(lambda: gate.poses[-1].twist == (0.0, 0.0))
            begun, ended = [next(p for p in gate.poses if p.twist == (0.1, 0.0)), gate.poses[-1]]
            assert ended.stamp > begun.stamp
            assert ended.x > 0.0
        async with table() as (running, outside):
            gate = Gate(outside, running.config, 0)
            await until(lambda: gate.poses)
            await command(running, gate, 0.1, 0.0)
            await until(lambda: gate.poses[-1].twist == (0.1, 0.0))
            count = len(gate.poses)
            await until(lambda: len(gate.poses) > count + 50)  # five times that timeout
            assert {pose.twist for pose in gate.poses[count:]} == {(0.1, 0.0)}

    run(main)


def test_a_table_that_is_too_late_warns_once_and_its_bodies_stand_still_meanwhile(
    caplog: pytest.LogCaptureFixture,
) -> None:
    async def main() -> None:
        async with table() as (running, outside):
            gate = Gate(outside, running.config, 0)
            await command(running, gate, 0.2, 0.0)
            for stall in (1, 2):
                await until(lambda: gate.poses and gate.poses[-1].twist == (0.2, 0.0))
                began, moved, lost = time.monotonic(), running.time, running.lost
                while time.monotonic() < began + 0.5:
                    pass  # as a stopped process: the loop does nothing
                await until(partial(has_lost, running, lost + 0.3))  # of 0.5 s, the last 0.1 s are made up for
                elapsed = time.monotonic() - began
                assert running.time - moved <= elapsed - 0.3, stall
        late = [record for record in caplog.records if "too late for real time" in record.message]
        assert len(late) == 1

    run(main)


def has_lost(running: Tabletop, seconds: float) -> bool:
    """True if the bodies have stood still for so many seconds."""
    return running.lost >= seconds


def test_the_relay_forwards_the_channels_share_of_datagrams_unchanged() -> None:
    separations, count = (60.0, 120.0), 2000
    poses = [(0.0, 0.0, 0.0), (separations[0], 0.0, 0.0), (0.0, separations[1], 0.0)]
    scenario = loop.load("tabletop.toml", robots__poses=poses)

    async def main() -> None:
        relay: Relay[Place] = Relay(3, Reachability(scenario).measure(np.array(poses), 0.0))
        with radio_socket.opened(("127.0.0.1", 0), relay, sealed.sender, seed=1) as radio:
            host, _, port = radio.place.rpartition(":")
            robots = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(3)]
            heard: list[set[bytes]] = [set() for _ in robots]
            try:
                for robot, its in enumerate(robots):
                    its.connect((host, int(port)))
                    its.setblocking(False)
                    its.send(datagram(robot, 0))
                await until(lambda: relay.sent.sum() >= 3)
                before = relay.sent[0].copy()
                sent = [datagram(0, number) for number in range(1, count + 1)]
                for first in range(0, count, 50):
                    for data in sent[first : first + 50]:
                        robots[0].send(data)
                    await until(partial(has_sent, relay, int(before[1]) + first + 50))
                    for robot, its in enumerate(robots):
                        heard[robot] |= waiting(its)
            finally:
                for its in robots:
                    its.close()
            assert radio.unsent == 0
            assert not heard[0] & set(sent)  # a robot never hears itself
            for robot, separation in enumerate(separations, 1):
                arrived = len(heard[robot] & set(sent))
                probability = math.exp(-3e-7 * separation**3)  # (3) with the paper's numbers
                deviation = math.sqrt(count * probability * (1.0 - probability))
                assert abs(arrived - count * probability) < 4.0 * deviation
                assert abs(relay.forwarded[0, robot] - arrived) <= 1  # the first datagram counts too

    run(main)


def has_sent(relay: Relay[Place], count: int) -> bool:
    """True if the relay has taken so many datagrams from robot 0 to robot 1."""
    return bool(relay.sent[0, 1] == count)


def datagram(robot: int, number: int) -> bytes:
    return sealed.seal(b"key", "test", robot, 1, number, b"beacon")


def waiting(its: socket.socket) -> set[bytes]:
    datagrams = set()
    while True:
        try:
            datagrams.add(its.recv(2000))
        except BlockingIOError:
            return datagrams


def test_a_relay_whose_port_is_taken_reports_it_and_a_flood_of_nonsense_is_counted_only() -> None:
    async def main() -> None:
        relay: Relay[Place] = Relay(10, Reachability(loop.load("tabletop.toml")).measure(np.zeros((10, 3)), 0.0))
        with radio_socket.opened(("127.0.0.1", 0), relay, sealed.sender, seed=1) as radio:
            host, _, port = radio.place.rpartition(":")
            with (
                pytest.raises(FesError, match=rf"^--radio {radio.place}: Address already in use$"),
                radio_socket.opened((host, int(port)), relay, sealed.sender, seed=1),
            ):
                pass
            with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
                for data in (b"", b"nonsense", bytes(2000), datagram(10, 1), datagram(11, 1)):
                    stranger.sendto(data, (host, int(port)))
                await until(lambda: relay.foreign == 5)
        assert not relay.sent.any()

    run(main)
