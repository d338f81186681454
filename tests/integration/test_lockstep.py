"""The lockstep over real Zenoh sessions, world and agents in one process: same digest as without Zenoh."""

import asyncio
from functools import partial
from typing import Any

import numpy as np
import pytest

from agents.process import Agent
from console.backends import inprocess
from fes.errors import Rejected, Unavailable
from fes.protocol import keys, messages
from fes.protocol.messages import Command, Join
from tests.support import attackers, session
from tests.support.attackers import arrived
from tests.support.loop import load
from tests.support.processes import PATIENCE
from tests.support.session import RUN, client
from world.config.scenario import Scenario
from world.execution.run import Run
from world.server.server import Server

SHORT = {"run__duration": 3.0}


@pytest.fixture(scope="module")
def paper() -> Scenario:
    return load("paper.toml", **SHORT)


@pytest.fixture(scope="module")
def expected(paper: Scenario) -> dict[str, Any]:
    return inprocess.run(paper, "test")


def run(scenario: Scenario, groups: list[list[int]], disturb: Any = None) -> Any:
    async def bounded() -> Any:
        async with asyncio.timeout(60.0):
            return await session.run(scenario, groups, disturb)

    return asyncio.run(bounded())


GROUPS = {
    "one robot each": [[i] for i in range(10)],
    "in reverse order": [[i] for i in reversed(range(10))],
    "three each": [[0, 1, 2], [3, 4, 5], [6, 7, 8], [9]],
    "all in one, some late": [[4, 5, 6, 7, 8, 9], [0, 1, 2, 3]],
}


@pytest.mark.parametrize("groups", GROUPS.values(), ids=GROUPS.keys())
def test_the_digest_depends_on_neither_zenoh_nor_placement_nor_start_order(
    paper: Scenario, expected: dict[str, Any], groups: list[list[int]]
) -> None:
    summary, server, _ = run(paper, groups)
    assert summary["digest"] == expected["digest"]
    assert summary["edges"] == expected["edges"]
    assert summary["beacons_decoded"] == expected["beacons_decoded"]
    assert not server.drops.counts


HARD = {"model": "logistic", "shadowing": {"deviation": 6.0}, "bursts": {"bad_share": 0.1, "mean_length": 0.2}}


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"seeking__pooling": "none", "run__clock_skew": 0.05, "channel": HARD},
        {"seeking__index": "sampled", "seeking__index_transform": "none"},
    ],
    ids=["pooled", "alone", "sampled"],
)
def test_a_measured_run_has_the_same_digest_over_zenoh(changes: dict[str, Any]) -> None:
    measured = load("measured.toml", **SHORT, **changes)
    summary, server, agents = run(measured, [[0, 1, 2], [3], [4, 5, 6, 7, 8, 9]])
    assert summary["digest"] == inprocess.run(measured, "test")["digest"]
    assert not server.drops.counts
    assert not any(agent.drops.counts for agent in agents)


def test_an_agent_subscribes_to_the_peers_in_range_only() -> None:
    # Three in a row, 100 m apart, range 150 m: the outer robots must not receive each other until they approach.
    apart = load("pair.toml", robots__poses=[[0.0, 0.0, 0.0], [100.0, 0.0, 0.0], [200.0, 0.0, 0.0]])
    still = apart.model_copy(update={"run": apart.run.model_copy(update={"duration": 0.1})})
    _, _, agents = run(still, [[0], [1], [2]])
    assert [agent.radio.peers for agent in agents] == [[1], [0, 2], [1]]


def test_an_agent_drops_its_subscription_when_a_peer_leaves() -> None:
    # 149.9 m apart, with a desired separation beyond the range of the radio: they part permanently.
    parting = load(
        "pair.toml",
        robots__poses=[[0.0, 0.0, np.pi], [149.0, 0.0, 0.0]],
        seeking__initial_estimate=[400.0, 400.0],
        run__duration=2.0,
    )
    summary, _, agents = run(parting, [[0], [1]])
    assert not summary["disk_connected_always"]
    assert [agent.radio.peers for agent in agents] == [[], []]


def test_garbage_on_any_key_is_counted_and_changes_no_digit(
    paper: Scenario, expected: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("agents.runtime.membership.secrets.randbelow", lambda most: attackers.AGENT)
    nothing = np.zeros(0, dtype=np.int64)
    forged = messages.encode_command(Command(10**9, 3, (1.0, 1.0), nothing, np.zeros(0), np.zeros(0)))

    async def disturb(endpoint: str, begin: asyncio.Event) -> None:
        async with client(endpoint) as vandal:
            begin.set()
            put = partial(vandal._session.put, attachment=attackers.MARK)
            for count in range(200):
                for robot in range(10):
                    put(keys.beacon(RUN, robot), b"\xc1 garbage")
                    put(keys.command(RUN, robot), forged)
                    put(keys.observation(RUN, robot), b"")
                put(f"fes/{RUN}/robot/*/command", b"wildcard")
                put(f"fes/{RUN}/robot/77/command", forged)
                put(keys.report(RUN), b"garbage")
                vandal._session.delete(keys.command(RUN, count % 10), attachment=attackers.MARK)
                await asyncio.sleep(0)
            await arrived(vandal)

    summary, server, agents = run(paper, [[i] for i in range(10)], disturb)
    assert summary["digest"] == expected["digest"]
    kinds = set(server.drops.counts)
    assert {"Command: is not for this tick", "Command: a deletion is not a command"} <= kinds
    assert all(agent.drops.counts for agent in agents)


def test_a_request_for_a_taken_or_unknown_robot_is_rejected_and_the_run_continues(
    paper: Scenario, expected: dict[str, Any]
) -> None:
    refusals: list[str] = []

    async def disturb(endpoint: str, begin: asyncio.Event) -> None:
        begin.set()
        for robots in ([42], [2, 3]):
            async with client(endpoint) as opened:
                agent = Agent(opened, RUN, tuple(robots))
                try:
                    await agent.join(PATIENCE)
                except Rejected as refused:
                    refusals.append(str(refused))

    summary, _, _ = run(paper, [[i] for i in range(10)], disturb)
    assert refusals[0] == "robot 42 does not exist: this run has robots 0 to 9"
    assert refusals[1] == "robot 2 is hosted by another agent already"
    assert summary["digest"] == expected["digest"]


def test_a_world_without_agents_ends_with_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("world.server.lockstep.RETURN_TIMEOUT", 1.0)
    endless = load("pair.toml", run__duration=1000.0)

    async def main() -> None:
        async with session.router() as (opened, endpoint):
            server = Server(opened, Run(endless), "test", RUN)
            agents = [asyncio.ensure_future(session.live(endpoint, [robot])) for robot in (0, 1)]
            await server.gather()
            running = asyncio.ensure_future(server.main_loop())
            while server.summarize() is None:
                await asyncio.sleep(0.01)
            for agent in agents:
                agent.cancel()
            with pytest.raises(Unavailable, match=r"^no robot is reachable: the world waited 1 s at tick \d+$"):
                await asyncio.wait_for(running, PATIENCE)

    asyncio.run(main())


def test_junk_does_not_keep_a_hung_robot_alive(monkeypatch: pytest.MonkeyPatch) -> None:
    """The deadline of the barrier holds although messages keep arriving."""
    monkeypatch.setattr("world.execution.barrier.ANSWER_TIMEOUT", 1.0)
    monkeypatch.setattr("world.server.lockstep.RETURN_TIMEOUT", 1.0)
    endless = load("pair.toml", run__duration=1000.0)

    async def main() -> None:
        async with session.router() as (opened, endpoint), client(endpoint) as silent, client(endpoint) as vandal:
            server = Server(opened, Run(endless), "test", RUN)
            for robot in (0, 1):
                await session.appear(silent, robot)
            await server.gather()
            running = asyncio.ensure_future(server.main_loop())
            for _ in range(400):
                vandal._session.put(keys.command(RUN, 0), b"junk", attachment=Join((0,), 0).mark)
                await asyncio.sleep(0.01)
                if running.done():
                    break
            with pytest.raises(Unavailable, match=r"^no robot is reachable: the world waited 1 s at tick 1$"):
                await asyncio.wait_for(running, PATIENCE)

    asyncio.run(main())


def test_an_agent_whose_world_leaves_ends_with_one_line() -> None:
    endless = load("pair.toml", run__duration=1000.0)

    async def main() -> None:
        async with session.router() as (opened, endpoint):
            server = Server(opened, Run(endless), "test", RUN)
            agents = [asyncio.ensure_future(session.live(endpoint, [robot], timeout=2.0)) for robot in (0, 1)]
            await server.gather()
            running = asyncio.ensure_future(server.main_loop())
            while server.summarize() is None:
                await asyncio.sleep(0.01)
            running.cancel()
        for agent in agents:
            with pytest.raises(Unavailable, match=r"^the world of run 'test' left after tick \d+$"):
                await asyncio.wait_for(agent, PATIENCE)

    asyncio.run(main())


def test_an_agent_without_a_world_times_out_and_names_what_it_waited_for() -> None:
    async def main() -> None:
        async with session.router() as (_, endpoint):
            with pytest.raises(Unavailable, match=r"^no world of run 'test' appeared within 0.2 s$"):
                await session.live(endpoint, [0], timeout=0.2)

    asyncio.run(main())
