"""A robot whose link is down when its run ends receives the farewell later, and its agent exits with success."""

import asyncio
import time

import pytest

from fes.errors import Unavailable
from tests.support import session
from tests.support.loop import load
from tests.support.processes import PATIENCE
from tests.support.proxy import Link, link
from tests.support.session import RUN
from world.execution.run import Run
from world.server import farewell
from world.server.server import Server

LAST = 40


async def end_with(fault: str, seconds: float) -> tuple[float, object]:
    """A run whose robot 1 has a faulty link at the farewell: the time for which the world lingers, and robot 1's end.

    The link works again after `seconds`.
    """
    scenario = load("pair.toml", run__duration=LAST * 0.02)
    async with session.router() as (opened, endpoint), link(endpoint) as faulty, asyncio.timeout(PATIENCE):
        server = Server(opened, Run(scenario), "test", RUN)
        agents = [
            asyncio.ensure_future(session.live(address, [robot]))
            for robot, address in enumerate((endpoint, faulty.endpoint))
        ]
        await server.gather()
        await server.main_loop()
        (Link.cut if fault == "cut" else Link.hold)(faulty)
        while fault == "cut" and server.lifecycle.hosting.alive[1]:
            await asyncio.sleep(0.01)
        server.dismiss()
        asyncio.get_running_loop().call_later(seconds, faulty.heal)
        begun = time.monotonic()
        await server.linger()
        lingered = time.monotonic() - begun
        [_, outcome] = await asyncio.gather(*agents, return_exceptions=True)
        return lingered, outcome


@pytest.mark.parametrize(("fault", "seconds"), [("hold", 0.3), ("hold", 3.0), ("cut", 0.3), ("cut", 2.0)])
def test_an_agent_that_is_disconnected_at_the_end_exits_with_0(fault: str, seconds: float) -> None:
    _, outcome = asyncio.run(end_with(fault, seconds))
    assert not isinstance(outcome, BaseException), outcome


def test_a_world_does_not_linger_after_every_robot_has_confirmed() -> None:
    lingered, outcome = asyncio.run(end_with("hold", 0.0))
    assert not isinstance(outcome, BaseException)
    assert lingered < farewell.LINGER


def test_a_world_lingers_for_a_bounded_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(farewell, "LINGER", 0.5)
    monkeypatch.setattr("tests.support.session.live", lambda endpoint, robots: impatient(endpoint, robots))
    lingered, outcome = asyncio.run(end_with("cut", 20.0))
    assert lingered >= 0.5
    assert isinstance(outcome, Unavailable)


live = session.live


async def impatient(endpoint: str, robots: list[int]) -> object:
    return await live(endpoint, robots, timeout=1.0)
