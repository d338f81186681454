"""The wait of a world before its run starts or resumes: the robots that count, and the end of the wait."""

import asyncio
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fes.arrays.types import Bools
from fes.errors import FesError, Rejected
from fes.protocol import keys
from tests.support import session
from tests.support.loop import load
from tests.support.session import RUN
from world.execution.checkpoint import CheckpointWriter
from world.execution.run import Run
from world.server.server import Options, Server


def test_a_world_does_not_start_with_robots_whose_agents_it_has_not_accepted() -> None:
    """Such as agents of an earlier world, which have not noticed yet that this is another one."""

    async def main() -> None:
        async with session.router() as (opened, endpoint), asyncio.timeout(60.0):
            server = Server(opened, Run(load("pair.toml", run__duration=0.2)), "test", RUN)
            gathering = asyncio.ensure_future(server.gather())
            async with session.client(endpoint) as stale:
                for robot in (0, 1):
                    stale.declare_token(keys.robot_alive(RUN, robot))
                while not server.lifecycle.hosting.alive.all():
                    await asyncio.sleep(0.01)
                with pytest.raises(Rejected, match="robot 1 is hosted by an agent of an earlier world"):
                    await session.live(endpoint, [1])
                assert not gathering.done()
            while server.lifecycle.hosting.alive.any():
                await asyncio.sleep(0.01)
            agents = [asyncio.ensure_future(session.live(endpoint, [robot])) for robot in (0, 1)]
            await gathering
            await server.main_loop()
            server.dismiss()
            await asyncio.gather(*agents)

    asyncio.run(main())


def test_a_world_that_cannot_record_joins_ends_instead_of_waiting_forever(tmp_path: Path) -> None:
    async def main() -> None:
        async with session.router() as (opened, endpoint), asyncio.timeout(60.0):
            checkpoints = CheckpointWriter(tmp_path, 1e9, "test", RUN)
            run = Run(load("pair.toml"), note=checkpoints.note)
            checkpoints.begin(run)
            assert checkpoints._journal is not None
            checkpoints._journal.close()
            checkpoints._journal._file = Path("/dev/full").open("ab", buffering=0)  # noqa: SIM115 (the writer closes it)
            server = Server(opened, run, "test", RUN, Options(checkpoints=checkpoints))
            gathering = asyncio.ensure_future(server.gather())
            with pytest.raises(Rejected, match="No space left on device"):
                await session.live(endpoint, [0])
            with pytest.raises(FesError, match="No space left on device"):
                await gathering
            checkpoints.discard(run)

    asyncio.run(main())


def test_a_robot_that_rejoins_a_resumed_world_takes_part_from_its_second_tick() -> None:
    """Observations of the first tick, published by the world before, must stay true."""

    async def main() -> tuple[Server, list[Bools]]:
        async with session.router() as (opened, endpoint), asyncio.timeout(100.0):
            run, took = Run(load("pair.toml", run__duration=0.4)), list[Bools]()
            run.state = replace(run.state, tick=5, present=np.array([True, False]), since=np.array([5, 0]))
            server, advance = Server(opened, run, "test", RUN), run.advance

            def taken(*words: Any) -> None:
                took.append(run.state.present)
                advance(*words)

            run.advance = taken  # type: ignore[assignment,method-assign]
            agents = [asyncio.ensure_future(session.live(endpoint, [robot])) for robot in (0, 1)]
            while not server.lifecycle.hosting.alive.all():
                await asyncio.sleep(0.01)
            await server.gather()
            await server.main_loop()
            server.dismiss()
            await asyncio.gather(*agents)
            return server, took

    server, took = asyncio.run(main())
    assert [present.tolist() for present in took] == [[True, False]] + [[True, True]] * 14
    assert server.run.state.since.tolist() == [5, 6]
