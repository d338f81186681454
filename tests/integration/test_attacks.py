"""Attacks on a running run over real Zenoh sessions: each is rejected and counted, and no digit changes."""

import asyncio
import logging
from typing import Any

import pytest

from fes.errors import Rejected
from fes.protocol import keys, messages, wire
from fes.protocol.messages import Join
from tests.support import session
from tests.support.attackers import (
    BAD_PAYLOADS,
    ROBOTS,
    arrived,
    attacked,
    beacon,
    command,
    everywhere,
    observation,
    put,
    ticks_go_by,
)
from tests.support.loop import load
from tests.support.processes import PATIENCE
from tests.support.session import RUN, client
from world.execution.run import Run
from world.server.server import Server


@pytest.mark.parametrize(("payload", "kind"), BAD_PAYLOADS.values(), ids=BAD_PAYLOADS.keys())
def test_a_bad_payload_on_every_key_is_counted_with_one_line_per_kind_and_changes_no_digit(
    payload: bytes, kind: str, caplog: pytest.LogCaptureFixture
) -> None:
    async def disturb(endpoint: str, begin: asyncio.Event) -> None:
        async with client(endpoint) as vandal:
            await ticks_go_by(vandal, 2, begin)  # at tick 0 a command for tick 0 would be valid
            for _ in range(5):
                for key, sent in everywhere(payload):
                    put(vandal, key, sent)
                await asyncio.sleep(0.01)
            await arrived(vandal)

    with caplog.at_level(logging.WARNING):
        server, agents = attacked(disturb)
    assert server.drops.counts[kind] >= ROBOTS - 1  # robot 3 is allowed the message on its own key
    logged = [record for record in caplog.records if record.name == "world" and kind in record.getMessage()]
    assert len(logged) == 1
    assert all(agent.drops.counts for agent in agents)


def test_repeated_late_and_early_ticks_are_rejected_and_change_no_digit() -> None:
    """Each message of an agent is sent again a little later, as by a network that repeats and reorders."""

    async def disturb(endpoint: str, begin: asyncio.Event) -> None:
        async with client(endpoint) as echo:
            kept: list[tuple[str, bytes]] = []

            def keep(key: str, payload: bytes | None) -> None:
                if payload is not None and len(kept) < 2000:
                    kept.append((key, payload))

            stop = [
                echo.declare_subscriber(key(RUN, "*"), keep) for key in (keys.beacon, keys.command, keys.observation)
            ]
            await ticks_go_by(echo, 20, begin)
            for undeclare in stop:
                undeclare()
            for key, payload in reversed(kept):
                put(echo, key, payload)
            for robot in range(ROBOTS):
                put(echo, keys.command(RUN, robot), command(10**6, robot))
                put(echo, keys.beacon(RUN, robot), beacon(10**6, robot))
                put(echo, keys.observation(RUN, robot), observation(10**6, robot))
            await arrived(echo)
            assert kept

    server, agents = attacked(disturb)
    assert server.drops.counts["Command: is not for this tick"] > 0
    assert all(agent.drops.counts["Observation: is not for this tick"] for agent in agents)
    assert any(agent.drops.counts["Beacon: from the future"] for agent in agents)


def test_a_second_command_for_a_tick_is_counted_and_the_first_one_applies(monkeypatch: pytest.MonkeyPatch) -> None:
    # An observation that is sent again allows a second answer.
    monkeypatch.setattr("world.execution.barrier.RESEND_AFTER", PATIENCE)
    endless = load("pair.toml", run__duration=1000.0)

    async def main() -> None:
        async with session.router() as (opened, endpoint), client(endpoint) as puppet:
            server = Server(opened, Run(endless), "test", RUN)
            for robot in (0, 1):
                await session.appear(puppet, robot)
            await server.gather()
            running = asyncio.ensure_future(server.main_loop())
            for linear in (0.0, 50.0, 60.0):  # the last robot gets its answer last, so all answers are of tick 0
                puppet._session.put(keys.command(RUN, 0), command(0, 0, linear), attachment=Join((0,), 0).mark)
            puppet._session.put(keys.command(RUN, 1), command(0, 1, 0.0), attachment=Join((1,), 1).mark)
            async with asyncio.timeout(PATIENCE):
                while server.summarize() is None:
                    await asyncio.sleep(0.01)
            running.cancel()
            assert server.drops.counts["Command: came twice"] == 2
            assert server.run.state.poses[0, :2].tolist() == [
                0.0,
                0.0,
            ]  # the pose of pair.toml: the robot did not move

    asyncio.run(main())


def nobody_hears_of(disturb: Any) -> None:
    server, agents = attacked(disturb)
    assert not server.drops.counts
    assert not any(agent.drops.counts for agent in agents)


def test_messages_of_another_run_on_the_same_router_are_not_received() -> None:
    async def disturb(endpoint: str, begin: asyncio.Event) -> None:
        async with client(endpoint) as vandal:
            await ticks_go_by(vandal, 5, begin)  # all have subscribed to their peers by now
            for _ in range(20):
                for key, sent in everywhere(b"\xc1 junk", "other"):
                    put(vandal, key, sent)
                await asyncio.sleep(0)
            await arrived(vandal)

    nobody_hears_of(disturb)


def test_a_payload_longer_than_the_limit_does_not_arrive_and_does_no_harm() -> None:
    async def disturb(endpoint: str, begin: asyncio.Event) -> None:
        async with client(endpoint) as vandal:
            await ticks_go_by(vandal, 5, begin)
            for key, _ in everywhere(b""):
                put(vandal, key, bytes(2 * wire.MAX_PAYLOAD))
            await arrived(vandal)

    nobody_hears_of(disturb)


def test_an_agent_that_requests_a_taken_robot_and_leaves_does_not_end_the_run() -> None:
    """Neither a request, which is rejected, nor a second token of the same robot ends the run."""

    async def disturb(endpoint: str, begin: asyncio.Event) -> None:
        begin.set()
        for _ in range(3):
            async with client(endpoint) as impostor:
                with pytest.raises(Rejected, match="robot 2 is hosted by another agent already"):
                    await impostor.get(keys.welcome(RUN, "2"), messages.encode_join(Join((2,), 7)), PATIENCE)
                for robot in (2, 77):
                    impostor.declare_token(keys.robot_alive(RUN, robot))
                await asyncio.sleep(0.02)

    server, _ = attacked(disturb)
    assert server.drops.counts["Join: refused"] == 3
    assert server.drops.counts["liveliness: unknown robot"] >= 3


def test_a_key_cannot_forge_a_log_line(caplog: pytest.LogCaptureFixture) -> None:
    forged = keys.welcome(RUN, f"1\n2026-01-01 world: all is well\x1b[2J{'x' * 5000}")

    async def disturb(endpoint: str, begin: asyncio.Event) -> None:
        async with client(endpoint) as vandal:
            with pytest.raises(Rejected):
                await vandal.get(forged, messages.encode_join(Join((3,), 1)), PATIENCE)

    with caplog.at_level(logging.WARNING):
        server, _ = attacked(disturb)
    assert server.drops.counts
    assert any("all is well" in line for line in caplog.messages)
    assert all(len(line) < 400 and line.isprintable() for line in caplog.messages)
