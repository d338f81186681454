"""The waits of a world, on either clock: for robots that are due, and for its robots when it resumes a run."""

import asyncio
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from agents.process import Agent
from console.backends import inprocess
from console.backends.process_group import free_port
from fes.arrays.types import Bools
from fes.transport import bus
from fes.transport.endpoints import Endpoints
from tests.support import session
from tests.support.loop import load
from tests.support.processes import PATIENCE
from tests.support.session import RUN
from world.config.scenario import Scenario
from world.execution import checkpoint, resume
from world.execution.checkpoint import CheckpointWriter
from world.execution.run import Answer, Run
from world.server.live import WARM_UP
from world.server.lockstep import Lockstep
from world.server.server import Options, Server
from world.simulation.truth import State

DYING = [{"at": 0.2, "kill": [1]}, {"at": 0.6, "restart": [1]}]


async def due(scenario: Scenario, comes: bool) -> tuple[str, dict[str, Any]]:
    """A run whose robot 1 dies by schedule and really; when it is due again, it has no agent.

    Returns the robots for which the world then waited, and the summary. Robot 1 `comes` while the world waits.
    """
    async with session.router() as (opened, endpoint), asyncio.timeout(PATIENCE):
        server = Server(opened, Run(scenario), "test", RUN)
        agents = [asyncio.ensure_future(session.live(endpoint, [robot])) for robot in (0, 1)]
        await server.gather()
        late, waits = server.lifecycle.due, list[str]()

        async def die() -> None:
            agents[1].cancel()
            while server.lifecycle.hosting.alive[1]:
                await asyncio.sleep(0.01)

        present = server.clock.present

        async def dying(state: State) -> Bools:
            if state.tick == 15:
                await die()
            return await present(state)

        def missed(tick: int) -> list[int]:
            robots = late(tick)
            if robots and not waits:
                waits.append(f"{robots} at tick {tick}")
                if comes:
                    agents[1] = asyncio.ensure_future(session.live(endpoint, [1]))
            return robots

        server.clock.present = dying  # type: ignore[method-assign]
        server.lifecycle.due = missed  # type: ignore[method-assign]
        await server.main_loop()
        server.dismiss()
        await asyncio.gather(*agents, return_exceptions=True)
        summary = server.summarize()
        assert summary is not None
        return " ".join(waits), summary


def test_the_world_waits_for_a_robot_that_is_due() -> None:
    scenario = load("pair.toml", run__duration=1.0, event=DYING)
    waited, summary = asyncio.run(due(scenario, comes=True))
    assert waited == "[1] at tick 30"
    assert summary["digest"] == inprocess.run(scenario, "test")["digest"]
    assert summary["unscheduled_absences"] == 0


def test_a_due_robot_that_does_not_join_is_reported_and_the_run_continues(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """A missing robot does not end the run; the summary counts its absence, here from tick 30 to 50."""
    monkeypatch.setattr("world.server.lockstep.RETURN_TIMEOUT", 0.5)
    scenario = load("pair.toml", run__duration=1.0, event=DYING)
    _, summary = asyncio.run(due(scenario, comes=False))
    assert (summary["ticks"], summary["unscheduled_absences"]) == (50, 20)
    late = "robots [1] are due at tick 30 and did not join within 0.5 s: the run continues without them"
    assert caplog.messages.count(late) == 1


def resumed_at(scenario: Scenario, tick: int) -> Run:
    """A run in which all robots took part, resumed at a tick."""
    run = Run(scenario)
    run.state = replace(run.state, tick=tick)
    return run


def test_a_resumed_world_waits_for_a_robot_that_died_meanwhile_and_then_excludes_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("world.server.server.RESUME_TIMEOUT", 0.5)

    async def main() -> Server:
        async with session.router() as (opened, endpoint), asyncio.timeout(PATIENCE):
            server = Server(opened, resumed_at(load("pair.toml", run__duration=0.4), 5), "test", RUN)
            agent = asyncio.ensure_future(session.live(endpoint, [0]))
            while not server.lifecycle.hosting.hosted[0]:
                await asyncio.sleep(0.01)
            await server.gather()  # no agent joins for robot 1
            assert server.lifecycle.hosting.alive.tolist() == [1, 0]
            await server.main_loop()
            server.dismiss()
            await agent
            return server

    server = asyncio.run(main())
    assert server.run.is_over
    assert server.run.state.present.tolist() == [True, False]


def test_a_robot_that_rejoins_within_the_wait_is_not_excluded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("world.server.server.RESUME_TIMEOUT", PATIENCE)

    async def main() -> Bools:
        async with session.router() as (opened, endpoint), asyncio.timeout(PATIENCE):
            server = Server(opened, resumed_at(load("pair.toml"), 5), "test", RUN)
            gathering = asyncio.ensure_future(server.gather())
            async with session.client(endpoint) as puppet:
                await session.appear(puppet, 0)
                while not server.lifecycle.hosting.hosted[0]:
                    await asyncio.sleep(0.01)
                assert not gathering.done()
                await session.appear(puppet, 1)
                await gathering
                return server.lifecycle.reachable

    assert asyncio.run(main()).all()


@pytest.mark.parametrize("torn", [False, True], ids=["to the tick it died at", "to one before"])
def test_a_live_run_whose_world_dies_resumes_in_lockstep_at_an_answered_tick(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, torn: bool
) -> None:
    monkeypatch.setattr("world.server.server.RESUME_TIMEOUT", PATIENCE)
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    scenario = load("pair.toml", run__duration=1.6, run__clock="live")
    barrier, collect = list[tuple[int, list[bool]]](), Lockstep.collect

    async def collected(lockstep: Lockstep, state: State, sent: list[bytes]) -> tuple[list[Answer | None], Bools]:
        answers, present = await collect(lockstep, state, sent)
        barrier.append((state.tick, present.tolist()))
        return answers, present

    monkeypatch.setattr(Lockstep, "collect", collected)

    async def first(agents: list["asyncio.Task[None]"], robots: list[Agent]) -> int:
        """A world that dies when its robots have answered a tick without a note; returns that tick."""
        dies, for_ever = asyncio.Event(), asyncio.Event()
        async with bus.opened(Endpoints("router", (), (endpoint,))) as opened:
            checkpoints = CheckpointWriter(tmp_path, 1e9, "test", RUN)
            run = Run(scenario, note=checkpoints.note)
            checkpoints.begin(run)
            server = Server(opened, run, "test", RUN, Options(checkpoints=checkpoints))
            agents += [asyncio.ensure_future(host(robot, robots)) for robot in (0, 1)]
            await server.gather()
            end_of_tick = server.clock.collect

            async def held(state: State, sent: list[bytes]) -> tuple[list[Answer | None], Bools]:
                if state.tick >= WARM_UP + 5:
                    dies.set()
                    await for_ever.wait()
                return await end_of_tick(state, sent)

            server.clock.collect = held  # type: ignore[method-assign]
            running = asyncio.ensure_future(server.main_loop())
            await dies.wait()
            while any(robot._ticks.tick < run.state.tick for robot in robots):
                await asyncio.sleep(0.01)
            running.cancel()
            checkpoints.close(run)
            return run.state.tick

    async def host(robot: int, robots: list[Agent]) -> None:
        async with session.client(endpoint) as opened:
            agent = Agent(opened, RUN, (robot,))
            robots.append(agent)
            await agent.live(await agent.join(PATIENCE))

    async def second() -> tuple[int, Run]:
        """Its successor; returns its first tick, and the run."""
        async with bus.opened(Endpoints("router", (), (endpoint,))) as opened:
            run, checkpoints, elapsed = resume.run(tmp_path, resume.load(tmp_path), None, 1e9)
            begun = run.state.tick
            server = Server(opened, run, "test", RUN, Options(checkpoints=checkpoints, elapsed=elapsed))
            await server.gather()
            await server.main_loop()
            server.dismiss()
            checkpoints.discard(run)
            return begun, run

    async def main() -> tuple[int, int, Run]:
        agents, robots = list["asyncio.Task[None]"](), list[Agent]()
        async with asyncio.timeout(PATIENCE):
            died = await first(agents, robots)
            if torn:
                [notes] = checkpoint.journals(tmp_path, 1)
                notes.write_bytes(notes.read_bytes()[:-1])
            begun, run = await second()
            await asyncio.gather(*agents)
            return died, begun, run

    died, begun, run = asyncio.run(main())
    assert begun == died - torn
    ticks = [*range(WARM_UP), *range(begun, begun + WARM_UP)]
    assert barrier == [(tick, [True, True]) for tick in ticks]  # each of them was answered
    assert run.state.tick == scenario.ticks > begun + WARM_UP
    assert run.state.since.tolist() == [0, 0]  # no robot was excluded
