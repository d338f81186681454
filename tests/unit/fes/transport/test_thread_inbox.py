"""The inbox between Zenoh's threads and the thread of an agent's ticks: nothing lost, no waiting for ever."""

import threading

import pytest

from fes.errors import Unavailable
from fes.transport.inbox import ThreadInbox

LONG = 60.0
"""A timeout [s] that no wait of these tests reaches."""


def test_a_wait_ends_when_enough_messages_have_come_from_other_threads() -> None:
    inbox = ThreadInbox()

    def hand_over(thread: int) -> None:
        for number in range(250):
            inbox.put(f"{thread}/{number}", b"")

    threads = [threading.Thread(target=hand_over, args=(thread,), daemon=True) for thread in range(4)]
    for thread in threads:
        thread.start()
    assert inbox.wait(1000, LONG)
    keys = [key for key, _ in inbox.drain()]
    assert len(keys) == len(set(keys)) == 1000
    for number in range(4):  # each thread's messages in the order it put them
        assert [key for key in keys if key.startswith(f"{number}/")] == [f"{number}/{count}" for count in range(250)]


def test_many_rounds_of_waiting_for_threads_lose_no_wake_up() -> None:
    rounds, inbox, turn = 2000, ThreadInbox(), threading.Semaphore(0)

    def answer() -> None:
        for _ in range(rounds):
            turn.acquire()
            inbox.put("key", b"")

    for _ in range(2):
        threading.Thread(target=answer, daemon=True).start()
    arrived = 0
    for _ in range(rounds):
        turn.release(2)
        assert inbox.wait(2, LONG)
        arrived += len(inbox.drain())
    assert arrived == 2 * rounds


def test_a_wait_that_times_out_returns_false_and_keeps_the_arrived_messages() -> None:
    inbox = ThreadInbox()
    inbox.put("a", b"1")
    assert not inbox.wait(2, 0.01)
    inbox.put("b", None)
    assert inbox.wait(2, 0.0)
    assert inbox.drain() == [("a", b"1"), ("b", None)]


def test_a_failure_ends_a_wait_in_another_thread_and_the_first_one_is_reported() -> None:
    inbox = ThreadInbox()
    threading.Timer(0.01, lambda: inbox.fail(Unavailable("the world left"))).start()
    with pytest.raises(Unavailable, match="the world left"):
        inbox.wait(1, LONG)
    inbox.fail(Unavailable("later"))
    with pytest.raises(Unavailable, match="the world left"):
        inbox.wait(1, LONG)


def test_messages_before_a_failure_are_still_read_but_not_those_before_the_end() -> None:
    failed, closed = ThreadInbox(), ThreadInbox()
    for inbox in (failed, closed):
        inbox.put("farewell", b"over")
    failed.fail(Unavailable("the world left"))
    assert failed.wait(2, LONG)
    assert failed.drain() == [("farewell", b"over")]
    closed.close(Unavailable("the agent is stopped"))
    with pytest.raises(Unavailable, match="the agent is stopped"):
        closed.wait(1, LONG)
