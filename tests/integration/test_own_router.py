"""A separate Zenoh router, configured by `fes keys rules`: it carries a run, and no forgery."""

import asyncio
import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest
import zenoh

from agents.process import Agent
from console.backends import inprocess
from console.backends.process_group import free_port
from console.keys import certificates
from fes.protocol import keys
from fes.transport import bus
from fes.transport.bus import Bus
from fes.transport.endpoints import Endpoints
from tests.support import team_keys
from tests.support.commands import call
from tests.support.loop import load
from tests.support.processes import PATIENCE
from world.execution.run import Run
from world.server.server import Server

RUN = "lab"
FORGED = [keys.command(RUN, 0), keys.beacon(RUN, 0), keys.report(RUN), keys.observation(RUN, 0)]
ROLES = ["world", "robot-0", "robot-1"]


@pytest.fixture(scope="module")
def keyed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return team_keys.directory(tmp_path_factory.mktemp("pki") / "keys", certificates.create(1.0), ROLES)


def configuration(keyed: Path, endpoint: str, *words: str) -> str:
    """The output of the command for a run of two robots."""
    done = call(keyed.parent, "fes", "keys", "rules", "--robots", "2", "--run", RUN, "--listen", endpoint, *words)
    assert (done.returncode, done.stderr) == (0, "")
    return done.stdout


@asynccontextmanager
async def client(keyed: Path, role: str, endpoint: str) -> AsyncIterator[Bus]:
    own = team_keys.security(keyed, role)
    async with bus.opened(Endpoints("client", (endpoint,), timeout=PATIENCE, security=own)) as opened:
        yield opened


async def live(keyed: Path, robot: int, endpoint: str) -> None:
    async with client(keyed, f"robot-{robot}", endpoint) as opened:
        agent = Agent(opened, RUN, (robot,))
        await agent.live(await agent.join(PATIENCE))


async def carried(keyed: Path, near: str, far: str) -> str:
    """The digest of a run with the world at one router and its robots at another, or at the same one."""
    async with client(keyed, "world", near) as opened, asyncio.timeout(PATIENCE):
        server = Server(opened, Run(load("pair.toml", run__duration=2.0)), "pair", RUN)
        agents = [asyncio.ensure_future(live(keyed, robot, far)) for robot in range(2)]
        await server.gather()
        await server.main_loop()
        server.dismiss()
        await asyncio.gather(*agents)
        summary = server.summarize()
        assert summary is not None
        return str(summary["digest"])


def expected() -> str:
    return str(inprocess.run(load("pair.toml", run__duration=2.0), "pair")["digest"])


def test_a_router_with_the_printed_rules_carries_a_run_to_the_same_digest(keyed: Path) -> None:
    endpoint = f"tls/127.0.0.1:{free_port()}"
    with zenoh.open(zenoh.Config.from_json5(configuration(keyed, endpoint))):
        assert asyncio.run(carried(keyed, endpoint, endpoint)) == expected()


def test_two_routers_with_the_printed_rules_are_linked_and_carry_a_run(keyed: Path) -> None:
    near, far = (f"tls/127.0.0.1:{free_port()}" for _ in range(2))
    with (
        zenoh.open(zenoh.Config.from_json5(configuration(keyed, near))),
        zenoh.open(zenoh.Config.from_json5(configuration(keyed, far, "--connect", near))),
    ):
        assert asyncio.run(carried(keyed, near, far)) == expected()


def forged(keyed: Path, text: str, endpoint: str) -> set[str]:
    """The keys on which a world behind a router receives forgeries of robot 1."""
    heard: list[tuple[str, bytes | None]] = []

    async def main() -> None:
        async with client(keyed, "world", endpoint) as world, client(keyed, "robot-1", endpoint) as forger:
            world.declare_subscriber(keys.tree(RUN), lambda key, payload: heard.append((key, payload)))
            said = [(forger.declare_publisher(key, "x"), b"forged") for key in FORGED]
            said.append((forger.declare_publisher(keys.command(RUN, 1), "x"), b"own"))
            async with asyncio.timeout(PATIENCE):
                # A put before this one has arrived, or never will. Before the subscription is known none arrives, and
                # the first round that arrives may be incomplete.
                while heard.count((keys.command(RUN, 1), b"own")) < 2:
                    for put, payload in said:
                        put(payload)
                    await asyncio.sleep(0.05)

    with zenoh.open(zenoh.Config.from_json5(text)):
        asyncio.run(main())
    return {key for key, payload in heard if payload == b"forged"}


def test_forged_messages_do_not_pass_a_router_with_the_printed_rules(keyed: Path) -> None:
    endpoint = f"tls/127.0.0.1:{free_port()}"
    assert forged(keyed, configuration(keyed, endpoint), endpoint) == set()


def test_without_the_rules_forged_messages_pass_a_router(keyed: Path) -> None:
    endpoint = f"tls/127.0.0.1:{free_port()}"
    text = json.loads(configuration(keyed, endpoint))
    text["access_control"]["enabled"] = False
    assert forged(keyed, json.dumps(text), endpoint) == set(FORGED)
