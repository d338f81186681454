"""Retransmission of an agent's latest beacons and commands."""

import logging
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

from agents.runtime.outbox import Outbox
from fes.protocol import keys, messages
from fes.transport.drop_log import DropLog

Desk = Callable[[Any], None]


class Kept:
    """A bus that keeps what is put, and asks what is served."""

    def __init__(self) -> None:
        self.put: list[tuple[str, bytes]] = []
        self.desks: dict[str, Desk] = {}

    def declare_publisher(self, key: str, schema: str, mark: bytes | None = None) -> Callable[[bytes], None]:
        return lambda payload: self.put.append((key, payload))

    def declare_queryable(self, key: str, desk: Desk) -> None:
        self.desks[key] = desk

    def recall(self, robot: int, tick: int) -> str:
        """The reply to a query for a beacon."""
        said: list[str] = []
        asked = SimpleNamespace(payload=messages.encode_recall(tick), reply_err=said.append)
        asked.reply = lambda payload, schema: said.append(payload.decode())
        self.desks[keys.recall("test", robot)](asked)
        [answer] = said
        return answer


def test_only_the_last_two_ticks_can_be_recalled_and_resent() -> None:
    """A peer that is a tick behind asks for what was said before the last word."""
    kept = Kept()
    outbox = Outbox(kept, "test", (4, 7), DropLog(logging.getLogger("test")))  # type: ignore[arg-type]
    for tick in range(10):
        outbox.publish(tick, [(robot, b"beacon %d of %d" % (tick, robot), b"command %d" % tick) for robot in (4, 7)])
    assert [kept.recall(7, tick) for tick in (9, 8)] == ["beacon 9 of 7", "beacon 8 of 7"]
    assert kept.recall(7, 7) == "robot 7 does not remember its beacon of tick 7"
    assert [outbox.has(tick) for tick in (10, 9, 8, 7)] == [False, True, True, False]
    kept.put.clear()
    outbox.resend(8, 4)
    assert kept.put == [(keys.beacon("test", 4), b"beacon 8 of 4"), (keys.command("test", 4), b"command 8")]
