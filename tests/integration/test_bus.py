"""The bus on real Zenoh sessions, and the behavior of Zenoh that the lockstep relies on."""

import asyncio
import time
from collections.abc import Awaitable, Callable

import pytest

from fes.errors import FesError, Rejected, TransportError, Unavailable
from fes.transport import bus
from fes.transport.bus import Query
from fes.transport.endpoints import Endpoints
from tests.support.processes import PATIENCE
from tests.support.session import client, router


async def until(holds: Callable[[], bool]) -> None:
    """Wait until a condition holds that another thread makes true."""
    async with asyncio.timeout(PATIENCE):
        while not holds():
            await asyncio.sleep(0.005)


def run(main: Callable[[], Awaitable[None]]) -> None:
    async def bounded() -> None:
        async with asyncio.timeout(PATIENCE):
            await main()

    asyncio.run(bounded())


def test_a_payload_arrives_with_its_key_and_a_deletion_as_none() -> None:
    async def main() -> None:
        async with router() as (world, endpoint), client(endpoint) as agent:
            got: list[tuple[str, bytes | None]] = []
            world.declare_subscriber("a/*", lambda key, payload: got.append((key, payload)))
            put = agent.declare_publisher("a/b", "x")
            put(b"hello")
            await until(lambda: bool(got))
            agent._session.delete("a/b")
            await until(lambda: len(got) == 2)
            assert got == [("a/b", b"hello"), ("a/b", None)]

    run(main)


def test_a_subscription_declared_before_a_command_receives_every_beacon_after_the_next_tick() -> None:
    """The order that makes the lockstep exact: declare, then answer. A put after the next tick is received."""

    async def main() -> None:
        async with router() as (world, endpoint), client(endpoint) as first, client(endpoint) as second:
            ticks: dict[str, asyncio.Queue[bytes | None]] = {"one": asyncio.Queue(), "two": asyncio.Queue()}
            commands: asyncio.Queue[bytes | None] = asyncio.Queue()
            loop = asyncio.get_running_loop()

            def to(queue: asyncio.Queue[bytes | None]) -> Callable[[str, bytes | None], None]:
                def hand_over(key: str, payload: bytes | None) -> None:
                    loop.call_soon_threadsafe(queue.put_nowait, payload)

                return hand_over

            world.declare_subscriber("command", to(commands))
            first.declare_subscriber("tick/one", to(ticks["one"]))
            second.declare_subscriber("tick/two", to(ticks["two"]))
            tick = {name: world.declare_publisher(f"tick/{name}", "x") for name in ticks}
            answer = {"one": first.declare_publisher("command", "x"), "two": second.declare_publisher("command", "x")}
            beacon = second.declare_publisher("beacon/0", "x"), second.declare_publisher("beacon/1", "x")
            await until(lambda: _settled(tick, ticks))
            for round_ in range(300):
                for put in tick.values():
                    put(b"%d" % round_)
                await ticks["two"].get()
                await ticks["one"].get()
                # The first session declares a subscription per tick; the second one publishes from the next tick on.
                box = first.mailbox(f"beacon/{round_ % 2}")
                answer["one"](b"done")
                answer["two"](b"done")
                await commands.get()
                await commands.get()
                for put in tick.values():
                    put(b"%d" % round_)
                await ticks["two"].get()
                beacon[round_ % 2](b"%d" % round_)
                answer["two"](b"done")
                await commands.get()
                tick["one"](b"read")
                assert await ticks["one"].get() is not None
                assert await ticks["one"].get() == b"read"
                taken = box.take()
                assert taken is not None
                assert taken[1] == b"%d" % round_
                box.close()

    run(main)


def _settled(puts: dict[str, Callable[[bytes], None]], queues: dict[str, "asyncio.Queue[bytes | None]"]) -> bool:
    """True if both subscriptions are in place, because each put has arrived; leaves the queues empty."""
    if all(not queue.empty() for queue in queues.values()):
        for queue in queues.values():
            while not queue.empty():
                queue.get_nowait()
        return True
    for put in puts.values():
        put(b"?")
    return False


def test_liveliness_tokens_are_seen_before_during_and_after_a_subscription() -> None:
    async def main() -> None:
        seen: list[tuple[str, bool]] = []
        async with router() as (world, endpoint):
            async with client(endpoint) as agent:
                agent.declare_token("robot/1/alive")
                async with client(endpoint) as late:
                    late.declare_liveliness_subscriber("robot/*/alive", lambda key, alive: seen.append((key, alive)))
                    await until(lambda: seen == [("robot/1/alive", True)])
                world.declare_liveliness_subscriber("robot/*/alive", lambda key, alive: seen.append((key, alive)))
                await until(lambda: len(seen) == 2)
            await until(lambda: seen[-1] == ("robot/1/alive", False))

    run(main)


def test_a_query_is_answered_rejected_or_ignored() -> None:
    async def main() -> None:
        def on_question(query: Query) -> None:
            if query.payload == b"yes?":
                query.reply(b"yes", "x")
            else:
                query.reply_err("no, because")

        async with router() as (world, endpoint), client(endpoint) as agent:
            world.declare_queryable("desk", on_question)
            assert await agent.get("desk", b"yes?", PATIENCE) == b"yes"
            with pytest.raises(Rejected, match=r"^no, because$"):
                await agent.get("desk", b"no?", PATIENCE)
            with pytest.raises(Unavailable, match="no process answers on nowhere"):
                await agent.get("nowhere", b"", PATIENCE)
            kept: list[Query] = []
            world.declare_queryable("asleep", kept.append)
            with pytest.raises(Unavailable, match=r"no process answered on asleep within 0.3 s"):
                await agent.get("asleep", b"", 0.3)

    run(main)


def test_a_taken_port_an_unreachable_endpoint_and_bad_settings_are_reported_in_one_line_each() -> None:
    async def main() -> None:
        async with router() as (_, endpoint):
            with pytest.raises(TransportError, match=f"^cannot listen on {endpoint}: .*in use$"):
                async with bus.opened(Endpoints("router", (), (endpoint,))):
                    pass
        with pytest.raises(TransportError, match=r"^nothing listens on tcp/127.0.0.1:1 \(tried for 0.3 s\)$"):
            async with client("tcp/127.0.0.1:1", timeout=0.3):
                pass
        for setting in ("nocolon", "no/such/setting:1", "mode:{"):
            with pytest.raises(FesError, match=r"^--cfg") as caught:
                async with bus.opened(Endpoints("client", settings=(setting,))):
                    pass
            assert "\n" not in str(caught.value)

    run(main)


def test_connecting_can_be_stopped_at_once() -> None:
    async def main() -> None:
        async def connect() -> None:
            async with client("tcp/127.0.0.1:1", timeout=PATIENCE):
                pass

        task = asyncio.ensure_future(connect())
        await asyncio.sleep(0)
        begun = time.monotonic()
        task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await task
        assert time.monotonic() - begun < PATIENCE / 2  # long before the attempt would have ended

    run(main)


def test_a_full_mailbox_drops_the_oldest_message_and_never_blocks_its_sender() -> None:
    async def main() -> None:
        async with router() as (world, endpoint), client(endpoint) as agent:
            box, done = agent.mailbox("box"), asyncio.Event()
            loop = asyncio.get_running_loop()

            def on_end(key: str, payload: bytes | None) -> None:
                loop.call_soon_threadsafe(done.set)

            agent.declare_subscriber("end", on_end)
            put, end = world.declare_publisher("box", "x"), world.declare_publisher("end", "x")
            await until(lambda: put(b"first") is None and box.take() is not None)
            while box.take() is not None:
                pass
            for number in range(bus.MAILBOX + 10):
                put(b"%d" % number)
            while not done.is_set():
                end(b"")
                await asyncio.sleep(0.005)
            taken = box.take()
            assert taken == ("box", b"10")

    run(main)
