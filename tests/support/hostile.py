"""A team over TLS in which one robot, with a valid certificate, attacks the others."""

import asyncio
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any, NamedTuple

from agents.process import Agent
from agents.runtime.outbox import Outbox
from console.backends.process_group import free_port
from fes.errors import FesError
from fes.recording.layout import NAME
from fes.transport import bus
from fes.transport.bus import Bus
from fes.transport.endpoints import Endpoints
from tests.support import team_keys
from tests.support.loop import load
from tests.support.processes import PATIENCE
from tests.support.session import RUN
from world.config.scenario import Scenario
from world.execution import journal
from world.execution.checkpoint import FOLDER, CheckpointWriter
from world.execution.recorder import Recorder
from world.execution.run import Run
from world.server import access
from world.server.server import Options, Server

ROBOTS, HOSTILE, FIRST = 10, 4, 40
"""The hostile robot, in the middle of the ten, and its first hostile tick."""

TickPayloads = list[tuple[int, bytes, bytes]]
Attack = Callable[[Outbox, int, TickPayloads], None]
"""Beacon and command that replace those of the hostile robot, from tick FIRST on."""

Beside = Callable[[Bus], Awaitable[None]]
"""Concurrent actions of another session with the same certificate."""


class Outcome(NamedTuple):
    """Outcome of a run."""

    directory: Path
    summary: dict[str, Any]
    notes: list[list[Any]]
    """Notes of the journal."""
    ended: list[FesError | None]
    """Error of each agent, in id order; None for a success."""
    server: Server


def scenario(**overrides: object) -> Scenario:
    """Ten robots with the measured index, so that beacons carry statistics."""
    return load("measured.toml", run__duration=1.6, **overrides)


class Turncoat(Outbox):
    """Outbox that is correct until tick FIRST, then follows an `attack`."""

    attack: Attack

    def publish(self, tick: int, payloads: TickPayloads) -> None:
        if tick >= FIRST:
            self.attack(self, tick, payloads)
        else:
            super().publish(tick, payloads)


def _member(where: Path, endpoint: str, robot: int) -> Endpoints:
    own = team_keys.security(where, f"robot-{robot}")
    return Endpoints("client", (endpoint,), timeout=PATIENCE, security=own)


async def _live(endpoints: Endpoints, robot: int, attack: Attack | None) -> None:
    async with bus.opened(endpoints) as opened:
        agent = Agent(opened, RUN, (robot,))
        if attack is not None:
            agent._outbox.__class__, agent._outbox.attack = Turncoat, attack  # type: ignore[attr-defined]
        await agent.live(await agent.join(PATIENCE))


async def _run(where: Path, keyed: Path, attack: Attack, beside: Beside | None) -> Outcome:
    """Run certified agents, one of them hostile, with a journal and a log."""
    configured, endpoint = scenario(), f"tls/127.0.0.1:{free_port()}"
    rules = access.control(RUN, ROBOTS)
    world = Endpoints("router", (), (endpoint,), security={**team_keys.security(keyed, "world"), **rules})
    async with bus.opened(world) as opened:
        with Recorder(where / NAME, configured, "hostile", "processes") as recorder:
            checkpoints = CheckpointWriter(where, 1e9, "hostile", RUN)
            run = Run(configured, recorder, checkpoints.note)
            checkpoints.begin(run)
            server = Server(opened, run, "hostile", RUN, Options(checkpoints=checkpoints, guarded=True))
            agents = [
                asyncio.ensure_future(_live(_member(keyed, endpoint, i), i, attack if i == HOSTILE else None))
                for i in range(ROBOTS)
            ]
            await server.gather()
            if beside is None:
                await server.main_loop()
            else:
                async with bus.opened(_member(keyed, endpoint, HOSTILE)) as second:
                    disturbance = asyncio.ensure_future(beside(second))
                    await server.main_loop()
                    await disturbance
            if HOSTILE in run.excluded:
                await asyncio.wait([agents[HOSTILE]])  # it asks why it hears nothing, and is told
            server.dismiss()
            summary = server.summarize()
            assert summary is not None
            recorder.conclude(summary)
            outcomes = await asyncio.gather(*agents, return_exceptions=True)
            ended = [error if isinstance(error, FesError) else None for error in outcomes]
            notes = [note for path in (where / FOLDER).glob("journal-*") for note in journal.notes(path)]
            checkpoints.close(run)
            return Outcome(where, summary, notes, ended, server)


def run(where: Path, keyed: Path, attack: Attack, beside: Beside | None = None) -> Outcome:
    """Outcome of an attack, within a bounded time."""

    async def bounded() -> Outcome:
        async with asyncio.timeout(120.0):
            return await _run(where, keyed, attack, beside)

    return asyncio.run(bounded())
