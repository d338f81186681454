"""An observer on the bus of real robots: their reports, merged into one at 10 Hz."""

import asyncio
from collections import deque
from collections.abc import AsyncIterator

from console.connect.observer import FOREIGN_PERIOD, FOREIGN_REPORTS, RETURN
from console.team.merge import Team
from fes.errors import MessageError, Unavailable
from fes.protocol import keys, world_info
from fes.protocol.report import Report
from fes.protocol.robot_report import PERIOD, decode_robot_report
from fes.transport.bus import Bus

MAX_WAITING = 4096
"""Largest number of reports that wait for a slow observer; the oldest are dropped."""


async def reports(bus: Bus, run: str, timeout: float, team: Team) -> AsyncIterator[Report | None]:
    """A merged Report each PERIOD; None in a period without a report or a change of the robots alive.

    `team` holds the robots, for the caller too. The iteration ends once all robots have left: without a token or a
    report for RETURN [s], or for `timeout` if that is longer. Raises Unavailable if no robot appears within
    `timeout` [s], and MessageError if robots send only another version of the protocol.
    """
    loop = asyncio.get_running_loop()
    waiting: deque[tuple[str, bytes, float]] = deque(maxlen=MAX_WAITING)
    tokens: set[str] = set()
    foreign: list[float] = []
    present: list[int] = []
    since = due = loop.time()

    def on_report(key: str, payload: bytes | None) -> None:
        if payload is not None:
            waiting.append((key, payload, loop.time()))

    def on_token(key: str, alive: bool) -> None:
        (tokens.add if alive else tokens.discard)(key)
        if (robot := keys.robot_of(key)) is not None:
            team.expect(robot)

    bus.declare_subscriber(keys.robot_report(run, "*"), on_report)
    for key in (keys.robot_alive(run, "*"), keys.gate_alive(run, "*")):
        bus.declare_liveliness_subscriber(key, on_token)
    while True:
        due = max(due + PERIOD, loop.time())
        await asyncio.sleep(due - loop.time())
        is_new = False
        while waiting:
            try:
                is_new |= _add(team, *waiting.popleft())
            except MessageError as error:
                if world_info.speaks_otherwise(error) and not team.members:
                    foreign.append(loop.time())
                    if len(foreign) >= FOREIGN_REPORTS and foreign[-1] - foreign[0] >= FOREIGN_PERIOD:
                        raise
        before, now = present, loop.time()
        present = team.alive(now)
        if tokens or present:
            since = now
        elif now - since > (max(RETURN, timeout) if team.members else timeout):
            if team.members:
                return
            raise Unavailable(f"no real robot of run '{run}' appeared within {timeout:g} s")
        yield team.report(now) if team.members and (is_new or present != before) else None
        since += loop.time() - now  # time of the caller does not count


def _add(team: Team, key: str, payload: bytes, time: float) -> bool:
    """Add a report to the team, unless it speaks for another robot than its key; True if it is a new one."""
    report = decode_robot_report(payload)
    return report.robot == keys.robot_of(key) and team.add(report, time)
