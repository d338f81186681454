"""Agents that take any free robot."""

import asyncio
import logging
import subprocess
import sys
import time
from typing import Any

import pytest

from agents import process
from console.backends import inprocess
from fes.errors import Rejected, Unavailable
from fes.protocol.messages import Join
from fes.transport.drop_log import DropLog
from tests.support import session
from tests.support.loop import load
from tests.support.processes import PATIENCE
from tests.support.session import RUN, client
from world.config.scenario import agent_config
from world.execution.hosting import Membership
from world.execution.lifecycle import Lifecycle
from world.execution.run import Run
from world.server.registry import AgentRegistry, RunInfo
from world.server.server import Server


@pytest.fixture
def at_length(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let a query wait for its reply without a limit, so that an agent asks once."""
    monkeypatch.setattr("agents.process.PATIENCE", PATIENCE)


async def any_robot(endpoint: str, timeout: float = PATIENCE) -> int:
    async with client(endpoint) as opened:
        robot = await process.lease(opened, RUN, timeout)
        agent = process.Agent(opened, RUN, (robot,))
        await agent.live(await agent.join(timeout))
        return robot


async def here(server: Server, *robots: int) -> None:
    """Wait until these robots are hosted."""
    while not server.lifecycle.hosting.alive[list(robots)].all():
        await asyncio.sleep(0.01)


def test_agents_without_an_id_take_the_lowest_free_robots_and_the_digest_is_the_same() -> None:
    scenario = load("paper.toml", run__duration=1.0)

    async def main() -> Any:
        async with session.router() as (opened, endpoint), asyncio.timeout(60.0):
            server = Server(opened, Run(scenario), "test", RUN)
            joined = [asyncio.ensure_future(session.live(endpoint, [robot])) for robot in (0, 3)]
            await here(server, 0, 3)
            others = [asyncio.ensure_future(any_robot(endpoint)) for _ in range(8)]
            await server.gather()
            await server.main_loop()
            server.dismiss()
            await asyncio.gather(*joined)
            return sorted(await asyncio.gather(*others)), server.summarize()

    taken, summary = asyncio.run(main())
    assert taken == [1, 2, 4, 5, 6, 7, 8, 9]
    assert summary["digest"] == inprocess.run(scenario, "test")["digest"]


def test_a_robot_is_free_only_after_its_agent_has_left() -> None:
    async def main() -> None:
        async with session.router() as (opened, endpoint), asyncio.timeout(60.0):
            server = Server(opened, Run(load("pair.toml", run__duration=1000.0)), "test", RUN)
            first = asyncio.ensure_future(any_robot(endpoint))
            await here(server, 0)
            second = asyncio.ensure_future(any_robot(endpoint))
            await here(server, 1)
            async with client(endpoint) as third:
                with pytest.raises(Rejected, match=r"^all 2 robots are hosted already$"):
                    await process.lease(third, RUN, 0.5)
                first.cancel()
                assert await process.lease(third, RUN, PATIENCE) == 0
            second.cancel()

    asyncio.run(main())


@pytest.mark.usefixtures("at_length")
def test_a_resumed_world_leases_no_robot_whose_agent_may_still_rejoin() -> None:
    async def main() -> None:
        async with session.router() as (opened, endpoint), client(endpoint) as spare:
            scenario, drops = load("pair.toml"), DropLog(logging.getLogger("test"))
            hosts = {robot: Join((robot,), 7) for robot in (0, 1)}
            info = RunInfo(RUN, 2, agent_config(scenario))
            lifecycle = Lifecycle(2, scenario.participation, Membership(hosts), time.monotonic())
            AgentRegistry(
                opened, info, drops, lifecycle, on_join=lambda join: None, on_token=lambda robot, alive: None
            )
            with pytest.raises(Rejected, match=r"^all 2 robots are hosted already$"):
                await process.lease(spare, RUN, 0.5)

    asyncio.run(main())


@pytest.mark.usefixtures("at_length")
def test_without_a_world_there_is_nothing_to_lease() -> None:
    async def main() -> None:
        async with session.router() as (_, endpoint), client(endpoint) as lonely:
            with pytest.raises(Unavailable, match=r"^no world of run 'test' leases robots here \(asked for 0.5 s\)$"):
                await process.lease(lonely, RUN, 0.5)

    asyncio.run(main())


def test_an_agent_without_an_id_cannot_use_the_certificate_of_a_robot() -> None:
    words = ["-m", "agents.process", "--id", "auto", "--keys", "keys"]
    done = subprocess.run([sys.executable, *words], capture_output=True, text=True, timeout=60)
    assert done.returncode == 1
    assert done.stderr.strip().endswith("error: --id auto does not go with --keys: a certificate is for one robot")
