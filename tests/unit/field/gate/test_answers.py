"""Answers of a gate to its operators, which a thread sends."""

import threading

from field.gate.operator import MOST_ANSWERS, Answers
from tests.support.processes import PATIENCE


def test_answers_are_sent_in_order_by_another_thread_and_an_error_ends_none() -> None:
    answers, sent, done = Answers(), [], threading.Event()

    def fail() -> None:
        raise RuntimeError("the session is closed")

    answers.put(lambda: sent.append(threading.current_thread().name))
    answers.put(fail)
    answers.put(lambda: sent.append("second"))
    answers.put(done.set)
    assert done.wait(PATIENCE)
    assert sent == ["answers", "second"]


def test_there_is_no_room_while_many_answers_wait_and_a_put_never_waits() -> None:
    answers, room, done = Answers(), threading.Event(), threading.Event()

    def wait() -> None:
        room.wait(PATIENCE)

    answers.put(wait)
    assert answers.is_free
    for _ in range(MOST_ANSWERS + 1):
        answers.put(lambda: None)
    assert not answers.is_free
    answers.put(done.set)
    room.set()
    assert done.wait(PATIENCE)
    assert answers.is_free
