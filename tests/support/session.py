"""World and agents as tasks of one loop, over real Zenoh sessions on a free loopback port."""

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable, Sequence
from contextlib import asynccontextmanager
from typing import Any

from agents.process import Agent
from console.backends.process_group import free_port
from fes.arrays.types import Bools
from fes.protocol import keys, messages
from fes.protocol.messages import Join
from fes.transport import bus
from fes.transport.bus import Bus
from fes.transport.endpoints import Endpoints
from tests.support.processes import PATIENCE
from world.config.scenario import Scenario
from world.execution.recorder import Recorder
from world.execution.run import Run
from world.server.server import Server
from world.simulation.truth import State

RUN = "test"

LAST = 10
"""Ticks that remain to a run after its disturbance."""

Disturb = Callable[[str, asyncio.Event], Awaitable[None]]


@asynccontextmanager
async def router() -> AsyncIterator[tuple[Bus, str]]:
    """An open bus that listens, and its endpoint."""
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    async with bus.opened(Endpoints("router", (), (endpoint,))) as opened:
        yield opened, endpoint


@asynccontextmanager
async def client(endpoint: str, timeout: float = PATIENCE) -> AsyncIterator[Bus]:
    """An open bus that is a client of `endpoint`."""
    async with bus.opened(Endpoints("client", (endpoint,), timeout=timeout)) as opened:
        yield opened


async def appear(opened: Bus, robot: int) -> None:
    """Appear to the world as an agent of this robot that sends nothing by itself."""
    await opened.get(keys.welcome(RUN, str(robot)), messages.encode_join(Join((robot,), robot)), PATIENCE)
    opened.declare_token(keys.robot_alive(RUN, robot))


async def live(endpoint: str, robots: Sequence[int], timeout: float = PATIENCE) -> Agent:
    """One agent, from joining to the end of the run."""
    async with client(endpoint) as opened:
        agent = Agent(opened, RUN, tuple(robots))
        await agent.live(await agent.join(timeout))
        return agent


async def run(
    scenario: Scenario,
    groups: Sequence[Sequence[int]],
    disturb: Disturb | None = None,
    recorder: Recorder | None = None,
) -> tuple[dict[str, Any], Server, list[Agent]]:
    """Run a scenario with one agent per group, started in the given order; returns summary, server and agents.

    `disturb(endpoint, begin)`, if given, runs beside it, from when all robots are here: the run does not begin before
    `begin` is set, or it is done, and is not over before it is done. `recorder` gets every tick.
    """
    async with router() as (opened, endpoint):
        server = Server(opened, Run(scenario, recorder), "test", RUN)
        agents = [asyncio.ensure_future(live(endpoint, robots)) for robots in groups]
        await server.gather()
        if disturb is not None:
            begin = asyncio.Event()
            disturbance = asyncio.ensure_future(disturb(endpoint, begin))
            disturbance.add_done_callback(lambda done: begin.set())
            _wait_for(disturbance, server)
            await begin.wait()
        await server.main_loop()
        server.dismiss()
        ended = await asyncio.gather(*agents)
        summary = server.summarize()
        assert summary is not None
        return summary, server, ended


def _wait_for(disturbance: "asyncio.Future[None]", server: Server) -> None:
    """Make a world pause before its last ticks until `disturbance` is done; it fails as `disturbance` does."""
    present, last = server.clock.present, server.run.scenario.ticks - LAST

    async def held(state: State) -> Bools:
        if state.tick >= last:
            await disturbance
        return await present(state)

    server.clock.present = held  # type: ignore[method-assign]


def finished(
    scenario: Scenario, groups: Sequence[Sequence[int]], recorder: Recorder | None = None, seconds: float = PATIENCE
) -> tuple[dict[str, Any], Server, list[Agent]]:
    """As `run`, in a loop of its own; raises TimeoutError after so many `seconds`."""

    async def bounded() -> tuple[dict[str, Any], Server, list[Agent]]:
        async with asyncio.timeout(seconds):
            return await run(scenario, groups, None, recorder)

    return asyncio.run(bounded())
