"""Agents of one loop that die and rejoin."""

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable, Sequence
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

from agents.process import Agent
from fes.arrays.types import Bools
from tests.support import session
from tests.support.session import RUN
from world.config.scenario import Scenario
from world.execution.recorder import Recorder
from world.execution.run import Run
from world.server.server import Options, Server
from world.simulation.truth import State

Story = Callable[[Server, list["asyncio.Task[Agent]"], str], Awaitable[None]]


def live_through(
    scenario: Scenario,
    path: Path,
    story: Story,
    pace: float = 2.0,
    groups: Sequence[Sequence[int]] | None = None,
) -> dict[str, Any]:
    """Record a run with one agent per group or robot while `story` happens; returns its summary."""

    async def main() -> dict[str, Any]:
        async with session.router() as (opened, endpoint), asyncio.timeout(100.0):
            with Recorder(path, scenario, "test", "processes") as recorder:
                server = Server(opened, Run(scenario, recorder), "test", RUN, Options(pace))
                crews = groups or [[robot] for robot in range(scenario.robots.number)]
                agents = [asyncio.ensure_future(session.live(endpoint, crew)) for crew in crews]
                await server.gather()
                running = asyncio.ensure_future(server.main_loop())
                await story(server, agents, endpoint)
                await running
                server.dismiss()
                await asyncio.gather(*agents, return_exceptions=True)
                summary = server.summarize()
                assert summary is not None
                recorder.conclude(summary)
                return summary

    return asyncio.run(main())


@asynccontextmanager
async def standing_still(server: Server) -> AsyncIterator[None]:
    """Block during which no tick passes."""
    present, goes_on = server.clock.present, asyncio.Event()

    async def held(state: State) -> Bools:
        await goes_on.wait()
        return await present(state)

    server.clock.present = held  # type: ignore[method-assign]
    try:
        yield
    finally:
        server.clock.present = present  # type: ignore[method-assign]
        goes_on.set()


async def until(server: Server, holds: Callable[[Any], Any]) -> int:
    while not holds(server.run.state):
        await asyncio.sleep(0.01)
    return int(server.run.state.tick)
