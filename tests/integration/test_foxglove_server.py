"""The WebSocket server for Foxglove and Lichtblick, with real clients in one loop."""

import asyncio

from console.foxglove import server
from console.foxglove.server import Viewers
from fes.system import strict_json
from tests.support import foxglove_client
from tests.support.foxglove_client import Client, fields
from tests.support.frames import a_report

pytestmark = foxglove_client.needs_foxglove

TEAM = [(0.0, 0.0), (60.0, 0.0), (0.0, 60.0)]


def show(viewers: Viewers, tick: int, links: list[tuple[int, int]], robots: int = 2) -> None:
    viewers.show(a_report(TEAM[:robots], links, tick=tick, dt=0.02))


def has(*topics: str, tick: int) -> "foxglove_client.Condition":
    """The condition that a client has a message of each topic, and the Report of a tick."""

    def holds(client: Client) -> bool:
        latest = client.latest
        return {"/report", *topics} <= latest.keys() and fields(latest["/report"].message)["tick"] == str(tick)

    return holds


def test_a_world_that_resumes_a_run_begins_a_new_session_with_the_bodies_of_its_robots() -> None:
    async def story() -> None:
        with server.opened(0) as viewers:
            show(viewers, 50, [(0, 1)])
            async with foxglove_client.connected(viewers.port) as client:
                await client.until(has("/scene/robots", "/link/0-1/state", tick=50))
                assert len(set(client.sessions)) == 1
                client.latest.clear()
                show(viewers, 51, [(0, 1)])
                await client.until(has("/link/0-1/state", tick=51))
                assert "/scene/robots" not in client.latest
                client.latest.clear()
                show(viewers, 20, [(0, 1)])
                await client.until(has("/scene/robots", "/link/0-1/state", tick=20))
                assert len(set(client.sessions)) == 2
                assert client.times[-1] == client.latest["/link/0-1/state"].time == 20 * 20_000_000

    asyncio.run(story())


def test_a_link_that_appears_is_a_new_channel_for_all_clients() -> None:
    async def story() -> None:
        with server.opened(0) as viewers:
            async with (
                foxglove_client.connected(viewers.port) as first,
                foxglove_client.connected(viewers.port) as second,
            ):
                show(viewers, 0, [(0, 1)], robots=3)
                show(viewers, 1, [(0, 1), (1, 2)], robots=3)
                for client in (first, second):
                    await client.until(has("/link/0-1/state", "/link/1-2/state", tick=1))
                    separation = fields(client.latest["/link/1-2/state"].message)["separation"]
                    assert abs(separation - 60.0 * 2.0**0.5) < 1e-9

    asyncio.run(story())


def test_a_client_that_does_not_read_delays_no_report() -> None:
    """Its socket and its queue in the server hold less than the 14 MB of these messages."""
    crowd = [(float(robot), 0.0) for robot in range(200)]

    async def story() -> None:
        with server.opened(0) as viewers:
            async with (
                foxglove_client.connected(viewers.port) as idle,
                foxglove_client.connected(viewers.port) as client,
            ):
                viewers.show(a_report(crowd, tick=0))
                await idle.until(has("/tf", tick=0))  # it reads no more from here on
                for tick in range(1, 1000):
                    viewers.show(a_report(crowd, tick=tick))
                    await client.until(has("/tf", tick=tick))

    asyncio.run(story())


def test_a_program_that_speaks_no_websocket_does_not_disturb_the_clients() -> None:
    async def story() -> None:
        with server.opened(0) as viewers:
            _, writer = await asyncio.open_connection("127.0.0.1", viewers.port)
            writer.write(b"\x00\xff" * 5000)
            await writer.drain()
            show(viewers, 3, [(0, 1)])
            async with foxglove_client.connected(viewers.port) as client:
                await client.until(has("/tf", tick=3))
            writer.close()

    asyncio.run(story())


def test_a_client_can_only_read() -> None:
    async def story() -> None:
        with server.opened(0) as viewers:
            async with foxglove_client.connected(viewers.port) as client:
                channel = {"id": 1, "topic": "/tf", "encoding": "json", "schemaName": ""}
                await client.socket.send(strict_json.dumps({"op": "advertise", "channels": [channel]}))
                show(viewers, 3, [(0, 1)])
                await client.until(has("/tf", tick=3))
                assert client.capabilities == ["time"]
                assert {channel.encoding for channel in client.channels.values()} == {"protobuf"}

    asyncio.run(story())
