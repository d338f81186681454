"""An agent that is stopped in the middle of a run ends the thread of its ticks, as does a run that is over."""

import asyncio
import threading

import pytest

from tests.support import session
from tests.support.loop import load
from tests.support.processes import PATIENCE
from tests.support.session import RUN
from world.execution.run import Run
from world.server.server import Server


def tick_threads() -> int:
    return sum(thread.name.startswith("ticks") for thread in threading.enumerate())


def test_a_stopped_agent_ends_its_thread_before_its_session_closes() -> None:
    async def main() -> None:
        async with session.router() as (opened, endpoint):
            server = Server(opened, Run(load("pair.toml", run__duration=600.0)), "test", RUN)
            agents = [asyncio.ensure_future(session.live(endpoint, [robot])) for robot in (0, 1)]
            await server.gather()
            running = asyncio.ensure_future(server.main_loop())
            while server.run.state.tick < 10:
                await asyncio.sleep(0)
            for number, agent in enumerate(agents, 1):
                agent.cancel()
                with pytest.raises(asyncio.CancelledError):
                    await asyncio.wait_for(agent, PATIENCE)
                assert tick_threads() == len(agents) - number
            running.cancel()
            await asyncio.gather(running, return_exceptions=True)

    asyncio.run(main())


def test_a_run_that_is_over_leaves_no_thread() -> None:
    asyncio.run(session.run(load("pair.toml", run__duration=0.2), [[0], [1]]))
    assert tick_threads() == 0
