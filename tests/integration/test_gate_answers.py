"""Answers of a gate to its operators, which a thread sends."""

import asyncio
import threading

import pytest

from fes.errors import Overloaded
from fes.protocol.robot_control import RUNNING, STOPPED, GateStatus
from fes.transport.bus import Query
from field.gate import operator
from field.gate.operator import MOST_ANSWERS, MOST_WITH_STOPS, Answers
from tests.support.gate_stage import driving, gate, stage, until
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
    assert answers.has_room()
    for _ in range(MOST_ANSWERS + 1):
        answers.put(lambda: None)
    assert not answers.has_room()
    assert answers.has_room(MOST_WITH_STOPS)
    answers.put(done.set)
    room.set()
    assert done.wait(PATIENCE)
    assert answers.has_room()


def test_an_answer_that_waits_for_the_network_holds_up_neither_the_loop_nor_a_stop(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The network of the operator is congested: each answer waits for room."""
    room = threading.Event()
    at_once = Query.reply

    def waiting(query: Query, payload: bytes, schema: str) -> None:
        assert room.wait(PATIENCE)
        at_once(query, payload, schema)

    async def main() -> None:
        async with stage() as on, gate(on.settings) as link, driving(link, 0.1):
            while not await on.operator.has_started():
                await asyncio.sleep(0.01)
            await on.speed(lambda linear: linear >= 0.1)
            monkeypatch.setattr(Query, "reply", waiting)
            asked = asyncio.ensure_future(on.operator.status())
            length = len(on.body.received)
            await until(lambda: len(on.body.received) > length + 20)  # twists go out meanwhile
            stopped = asyncio.ensure_future(on.operator.stop())
            await on.speed(lambda linear: linear == 0.0)  # although its answer waits too
            assert not asked.done()
            assert not stopped.done()
            room.set()
            assert (await asked).mode == RUNNING
            assert (await stopped).mode == STOPPED

    async def bounded() -> None:
        async with asyncio.timeout(PATIENCE):
            await main()

    try:
        asyncio.run(bounded())
    finally:
        room.set()


def test_unread_answers_to_other_queries_do_not_keep_a_robot_from_its_stop(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    room = threading.Event()
    at_once = Query.reply

    def waiting(query: Query, payload: bytes, schema: str) -> None:
        assert room.wait(PATIENCE)
        at_once(query, payload, schema)

    async def main() -> None:
        monkeypatch.setattr(operator, "MOST_ANSWERS", 1)
        async with asyncio.timeout(PATIENCE), stage() as on, gate(on.settings) as link, driving(link, 0.1):
            while not await on.operator.has_started():
                await asyncio.sleep(0.01)
            await on.speed(lambda linear: linear >= 0.1)
            monkeypatch.setattr(Query, "reply", waiting)
            asked: list[asyncio.Future[GateStatus]] = []
            while not any(query.done() for query in asked):  # queries that arrive together all find room
                asked.append(asyncio.ensure_future(on.operator.status()))
                await asyncio.sleep(0.05)
            stopped = asyncio.ensure_future(on.operator.stop())
            await on.speed(lambda linear: linear == 0.0)
            room.set()
            assert (await stopped).mode == STOPPED
            answers = await asyncio.gather(*asked, return_exceptions=True)
            assert any(isinstance(answer, Overloaded) for answer in answers)

    try:
        asyncio.run(main())
    finally:
        room.set()
