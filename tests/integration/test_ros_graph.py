"""Keys, attachments and tokens of ROS 2 in the style of rmw_zenoh, over real Zenoh sessions."""

import asyncio

from fes.ros import graph
from fes.ros.graph import Node, parse_token
from fes.ros.messages import PoseMessage, read_pose, read_twist, write_pose, write_twist
from fes.ros.topics import Topic, attachment, publish_key, read_attachment, subscribe_key
from fes.transport import foreign
from fes.transport.bus import Bus
from tests.support.processes import PATIENCE
from tests.support.session import client, router

COMMAND = Topic("rmw_zenoh", "/robot3/cmd_vel", "Twist", 7)
POSE = Topic("rmw_zenoh", "/robot3/odom", "Odometry", 7)
BRIDGED = "@/3f2a/@ros2_lv/MP/robot3§odom/nav_msgs§msg§Odometry/:1:2:0,10"
GID = bytes(range(16))


def node(bus: Bus, name: str, domain: int = 7) -> Node:
    return Node(str(bus.session.zid()), name, "/robot3", domain)


async def ends(bus: Bus, pattern: str) -> list[tuple[str, str, str]]:
    """Node, type and session of each endpoint that the router knows."""
    known = [parse_token(token) for token in await bus.liveliness_get(pattern, PATIENCE)]
    return [(end.node, end.type, end.session) for end in known if end]


def test_an_observer_finds_the_publishers_and_subscribers_of_a_topic_and_their_types() -> None:
    async def check() -> None:
        async with router() as (_, endpoint), client(endpoint) as robot, client(endpoint) as observer:
            gate, other = node(robot, "gate"), node(robot, "other", 8)
            elsewhere = graph.tokens(other, [COMMAND._replace(domain=8)], [])
            for token in (*graph.tokens(gate, [COMMAND], [POSE]), *elsewhere, BRIDGED):
                robot.declare_token(token)
            await robot.liveliness_get(BRIDGED, PATIENCE)  # the router has what was declared before
            own = gate.session
            assert await ends(observer, graph.publishers(COMMAND)) == [("/robot3/gate", "Twist", own)]
            assert await ends(observer, graph.subscribers(POSE)) == [("/robot3/gate", "Odometry", own)]
            assert await ends(observer, graph.publishers(POSE)) == []
            bridged = POSE._replace(style="ros2dds")
            assert await ends(observer, graph.publishers(bridged)) == [("", "Odometry", "3f2a")]

    asyncio.run(check())


def test_a_twist_and_a_pose_pass_with_their_attachments_under_any_hash_of_the_sender() -> None:
    async def check() -> None:
        arrived: asyncio.Queue[tuple[bytes, bytes]] = asyncio.Queue()
        loop = asyncio.get_running_loop()

        def on_sample(key: str, payload: bytes, mark: bytes) -> None:
            loop.call_soon_threadsafe(arrived.put_nowait, (payload, mark))

        async def sent(key: str, payload: bytes, mark: bytes) -> tuple[bytes, bytes]:
            """The sample as it arrives; it is put again until the way is open."""
            put = foreign.declare_publisher(sender, key)
            async with asyncio.timeout(PATIENCE):
                while arrived.empty():
                    put(payload, mark)
                    await asyncio.sleep(0.01)
                return await arrived.get()

        async with router() as (_, endpoint), client(endpoint) as sender:
            async with client(endpoint) as receiver:
                foreign.declare_subscriber(receiver, subscribe_key(COMMAND), on_sample)
                mark = attachment(COMMAND, 1, 5, GID)
                payload, received = await sent(publish_key(COMMAND), write_twist("Twist", 0.25, -1.0), mark)
                assert read_twist("Twist", payload) == (0.25, -1.0)
                assert read_attachment(received) == (1, 5, GID)
            async with client(endpoint) as receiver:
                arrived = asyncio.Queue()
                foreign.declare_subscriber(receiver, subscribe_key(POSE), on_sample)
                humble = publish_key(POSE).rpartition("/")[0] + "/TypeHashNotSupported"
                message = PoseMessage(5, "map", 1.0, 2.0, 0.0, (0.5, 0.0))
                payload, received = await sent(humble, write_pose("Odometry", message), b"")
                assert (read_pose("Odometry", payload), received) == (message, b"")

    asyncio.run(check())
