"""The summary of a world is written even if its farewell fails."""

import argparse
import asyncio
import json
from pathlib import Path

import pytest

from console.backends.process_group import free_port
from fes.errors import FesError, TransportError
from tests.support import session
from tests.support.loop import load
from tests.support.paths import CONFIGS
from tests.support.processes import PATIENCE
from world import process
from world.server.server import Server


def test_a_failed_farewell_does_not_lose_the_summary(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    words = {
        "mode": None,
        "connect": [],
        "listen": [endpoint],
        "config": None,
        "cfg": [],
        "timeout": 10.0,
        "keys": None,
    }
    own = {"run": session.RUN, "name": None, "scenario": str(CONFIGS / "pair.toml"), "rtf": None}
    flags = argparse.Namespace(**words, **own, out=tmp_path, no_record=False, checkpoint=10.0)

    def broken(server: Server) -> None:
        raise TransportError("the bus broke")

    monkeypatch.setattr(Server, "dismiss", broken)

    async def main() -> None:
        start = process.Start(load("pair.toml", run__duration=0.4), "pair", session.RUN)
        world = asyncio.ensure_future(process.serve(flags, start))
        agents = [asyncio.ensure_future(session.live(endpoint, [robot])) for robot in (0, 1)]
        with pytest.raises(FesError, match="the bus broke"):
            await asyncio.wait_for(world, PATIENCE)
        for agent in agents:
            agent.cancel()
        await asyncio.gather(*agents, return_exceptions=True)

    asyncio.run(main())
    assert json.loads((tmp_path / "summary.json").read_text())["ticks"] == 20
