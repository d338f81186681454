"""The inbox between Zenoh's threads and the loop: nothing lost, nothing late, no waiting for ever."""

import asyncio
import threading
from collections.abc import Callable, Coroutine
from typing import TypeVar

import pytest

from fes.errors import Unavailable
from fes.transport import inbox as inboxes
from fes.transport.inbox import Inbox

T = TypeVar("T")
LONG = 240.0
"""A timeout [s] that no test may reach: the limit of `play` is below."""


def play(scene: Callable[[Inbox], Coroutine[None, None, T]]) -> T:
    """The outcome of a scene with a new inbox, which must end well before LONG."""

    async def main() -> T:
        async with asyncio.timeout(LONG / 4):
            return await scene(Inbox(asyncio.get_running_loop()))

    return asyncio.run(main())


def hand_over(inbox: Inbox, thread: int, count: int) -> None:
    for number in range(count):
        inbox.put(f"{thread}/{number}", b"")


def test_a_wait_ends_when_enough_messages_have_come_from_other_threads() -> None:
    async def scene(inbox: Inbox) -> tuple[bool, list[str]]:
        threads = [threading.Thread(target=hand_over, args=(inbox, k, 250), daemon=True) for k in range(4)]
        for thread in threads:
            asyncio.get_running_loop().call_soon(thread.start)
        enough = await inbox.wait(1000, LONG)
        for thread in threads:
            thread.join()
        return enough, [key for key, _ in inbox.drain()]

    enough, came = play(scene)
    assert enough
    assert len(came) == len(set(came)) == 1000
    for thread in range(4):  # each thread's messages in the order it put them
        own = [key for key in came if key.startswith(f"{thread}/")]
        assert own == [f"{thread}/{number}" for number in range(250)]


def test_many_rounds_of_waiting_for_threads_lose_no_wake_up() -> None:
    rounds = 2000

    async def scene(inbox: Inbox) -> int:
        turn = threading.Semaphore(0)

        def answer() -> None:
            for number in range(rounds):
                turn.acquire()
                inbox.put("key", str(number).encode())

        threads = [threading.Thread(target=answer, daemon=True) for _ in range(2)]
        for thread in threads:
            thread.start()
        came = 0
        for _ in range(rounds):
            turn.release(2)
            assert await inbox.wait(2, LONG)
            came += len(inbox.drain())
        for thread in threads:
            thread.join()
        return came

    assert play(scene) == 2 * rounds


def test_a_wait_for_messages_that_have_arrived_ends_at_once() -> None:
    async def scene(inbox: Inbox) -> tuple[bool, list[inboxes.Item], list[inboxes.Item]]:
        inbox.put("a", b"1")
        inbox.put("b", None)
        return await inbox.wait(2, 0.0), inbox.drain(), inbox.drain()

    assert play(scene) == (True, [("a", b"1"), ("b", None)], [])


def test_a_wait_that_times_out_returns_false_and_keeps_the_arrived_messages() -> None:
    async def scene(inbox: Inbox) -> tuple[bool, bool, float, list[inboxes.Item]]:
        loop = asyncio.get_running_loop()
        before = loop.time()
        inbox.put("a", b"1")
        first = await inbox.wait(2, 0.05)
        passed = loop.time() - before
        loop.call_soon(inbox.put, "b", b"2")
        return first, await inbox.wait(2, LONG), passed, inbox.drain()

    first, second, passed, came = play(scene)
    assert (first, second) == (False, True)
    assert passed >= 0.049  # the loop's clock may wake a resolution early
    assert came == [("a", b"1"), ("b", b"2")]


def test_a_failure_ends_the_current_wait_and_every_later_one() -> None:
    async def scene(inbox: Inbox) -> list[str]:
        asyncio.get_running_loop().call_soon(inbox.fail, Unavailable("the world left"))
        errors = []
        for _ in range(2):
            with pytest.raises(Unavailable) as caught:
                await inbox.wait(1, LONG)
            errors.append(str(caught.value))
        return errors

    assert play(scene) == ["the world left"] * 2


def test_messages_before_a_failure_are_still_read() -> None:
    async def scene(inbox: Inbox) -> list[inboxes.Item]:
        inbox.put("farewell", b"over")
        inbox.fail(Unavailable("the world left"))
        assert await inbox.wait(1, LONG)
        came = inbox.drain()
        with pytest.raises(Unavailable, match="the world left"):
            await inbox.wait(1, LONG)
        return came

    assert play(scene) == [("farewell", b"over")]


def test_the_first_of_two_failures_is_reported() -> None:
    async def scene(inbox: Inbox) -> str:
        inbox.fail(Unavailable("robot 3 left"))
        inbox.fail(Unavailable("robot 4 left"))
        with pytest.raises(Unavailable) as caught:
            await inbox.wait(1, LONG)
        return str(caught.value)

    assert play(scene) == "robot 3 left"


def test_messages_beyond_the_limit_are_dropped_and_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(inboxes, "LIMIT", 5)

    async def scene(inbox: Inbox) -> tuple[list[str], int, list[str]]:
        hand_over(inbox, 0, 8)
        kept, dropped = [key for key, _ in inbox.drain()], inbox.dropped
        inbox.put("after", b"")  # there is room again
        return kept, dropped, [key for key, _ in inbox.drain()]

    assert play(scene) == ([f"0/{number}" for number in range(5)], 3, ["after"])


def test_a_few_large_messages_fill_the_inbox_and_a_small_one_may_still_fit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(inboxes, "LIMIT_BYTES", 100)

    async def scene(inbox: Inbox) -> tuple[list[str], int, list[str]]:
        for key, size in (("a", 60), ("b", 41), ("c", 40), ("d", 1), ("e", 0)):
            inbox.put(key, bytes(size))
        inbox.put("f", None)
        kept, dropped = [key for key, _ in inbox.drain()], inbox.dropped
        inbox.put("after", bytes(100))
        return kept, dropped, [key for key, _ in inbox.drain()]

    assert play(scene) == (["a", "c", "e", "f"], 2, ["after"])


def test_the_inbox_has_a_large_limit() -> None:
    assert 10_000 <= inboxes.LIMIT <= 10_000_000
