"""Attacks on a run that goes on, over real Zenoh sessions: each is refused and counted, and no digit changes."""

import asyncio
import logging
import struct
import time
from collections.abc import Callable, Iterator
from typing import Any

import msgpack
import numpy as np
import pytest
import zenoh

from agents.process import Agent
from console import inprocess, observer
from fes import bus, change, keys, messages, wire
from fes.bus import Bus
from fes.errors import Absent, FesError, Refused
from fes.messages import Beacon, Command, Observation
from tests import session
from tests.loop import load
from tests.session import RUN, client
from world.scenario import Scenario
from world.server import Server

ROBOTS = 10
FLOOD = 10_000
NOBODY = np.zeros(0, dtype=np.int64)
NOTHING = np.zeros(0)

Attack = Callable[[Bus], Iterator[tuple[str, bytes]]]
"""Keys and payloads that a vandal puts."""


@pytest.fixture(scope="module")
def paper() -> Scenario:
    return load("paper.toml", run__duration=2.0)


@pytest.fixture(scope="module")
def expected(paper: Scenario) -> str:
    return str(inprocess.run(paper, "test")["digest"])


def attacked(scenario: Scenario, disturb: Any) -> tuple[str, Server, list[Agent]]:
    """Digest, world and agents of a run that is disturbed; the disturbance must end before the run is counted."""

    async def bounded() -> Any:
        async with asyncio.timeout(60.0):
            return await session.run(scenario, [[robot] for robot in range(ROBOTS)], disturb)

    summary, server, agents = asyncio.run(bounded())
    return summary["digest"], server, agents


def everywhere(payload: bytes, run: str = RUN) -> list[tuple[str, bytes]]:
    """A payload for every key that somebody listens to."""
    robots = [key(run, robot) for robot in range(ROBOTS) for key in (keys.beacon, keys.command, keys.observation)]
    return [(key, payload) for key in [*robots, keys.report(run), keys.welcome(run, "2-3"), keys.change(run)]]


def command(tick: int, robot: int, linear: float = 1.0) -> bytes:
    return messages.encode_command(Command(tick, robot, (linear, 1.0), NOBODY, NOTHING, NOTHING))


def beacon(tick: int, robot: int) -> bytes:
    return messages.encode_beacon(
        Beacon(tick, robot, (1.0, 2.0, 3.0), NOBODY, NOTHING, NOBODY.astype(np.uint8), NOTHING)
    )


def observation(tick: int, robot: int) -> bytes:
    nothing = NOBODY.astype(np.uint8)
    return messages.encode_observation(
        Observation(tick, robot, (9.0, 9.0, 9.0), NOBODY, nothing, over=False, since=0)
    )


def reversioned(payload: bytes) -> bytes:
    return msgpack.packb([2, *msgpack.unpackb(payload)[1:]])  # type: ignore[no-any-return]


NAN = struct.pack(">d", float("nan"))
BAD_PAYLOADS = {
    "junk": (b"\xc1 junk", "Command: is not msgpack (FormatError)"),
    "empty": (b"", "Command: is not msgpack (ValueError)"),
    "another protocol version": (reversioned(command(5, 3)), f"Command: {wire.WRONG_VERSION}"),
    "not a number": (command(5, 3).replace(struct.pack(">d", 1.0), NAN), "Command: expects a finite number"),
    "a mebibyte of zeros": (bytes(wire.MAX_PAYLOAD - 200), "Command: is not msgpack (ExtraData)"),
    "a tick long past": (command(0, 3), "Command: came on another robot's key"),
}


@pytest.mark.parametrize(("payload", "kind"), BAD_PAYLOADS.values(), ids=BAD_PAYLOADS.keys())
def test_a_bad_payload_on_every_key_is_counted_with_one_line_a_kind_and_changes_no_digit(
    paper: Scenario, expected: str, payload: bytes, kind: str, caplog: pytest.LogCaptureFixture
) -> None:
    async def disturb(endpoint: str) -> None:
        async with client(endpoint) as vandal:
            await asyncio.sleep(0.1)  # at tick 0 a command for tick 0 would be one like any other
            for _ in range(5):
                for key, sent in everywhere(payload):
                    vandal._session.put(key, sent)
                await asyncio.sleep(0.01)

    with caplog.at_level(logging.WARNING):
        digest, server, agents = attacked(paper, disturb)
    assert digest == expected
    assert server.complaints.counts[kind] >= ROBOTS - 1  # robot 3 may hear of itself what another would not
    said = [record for record in caplog.records if record.name == "world" and kind in record.getMessage()]
    assert len(said) == 1
    assert all(agent.complaints.counts for agent in agents)


def test_a_flood_of_junk_on_all_keys_at_once_changes_no_digit(paper: Scenario, expected: str) -> None:
    async def disturb(endpoint: str) -> None:
        targets = everywhere(b"\xc1 junk")

        def flood() -> None:
            for number in range(FLOOD):
                vandal._session.put(*targets[number % len(targets)])

        async with client(endpoint) as vandal:
            await asyncio.to_thread(flood)  # as fast as the network takes it

    digest, server, _ = attacked(paper, disturb)
    assert digest == expected
    # a third of the keys are commands; what came when the run was over is not counted
    assert 0 < server.complaints.counts["Command: is not msgpack (FormatError)"] <= FLOOD


@pytest.mark.parametrize("size", [1_000, 60_000])
def test_a_flood_that_waits_for_room_closes_no_robots_link(paper: Scenario, expected: str, size: int) -> None:
    """Messages sent with congestion control BLOCK: with two threads for all, two of them stopped the router."""

    async def disturb(endpoint: str) -> None:
        targets = everywhere(bytes(size))[: 3 * ROBOTS]

        def flood() -> None:
            for _ in range(6_000_000 // (size * len(targets)) + 5):
                for key, sent in targets:
                    vandal._session.put(key, sent, congestion_control=zenoh.CongestionControl.BLOCK)

        async with client(endpoint) as vandal:
            await asyncio.to_thread(flood)

    digest, _, _ = attacked(paper, disturb)
    assert digest == expected


def test_a_flood_that_pushes_beacons_out_of_full_mailboxes_changes_no_digit(
    paper: Scenario, expected: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With room for two samples nearly every beacon is lost to junk; each is asked for again."""
    monkeypatch.setattr(bus, "MAILBOX", 2)
    flooding = asyncio.Event()

    async def disturb(endpoint: str) -> None:
        async with client(endpoint) as vandal:
            for _ in range(150):
                for robot in range(ROBOTS):
                    for _ in range(10):
                        vandal._session.put(keys.beacon(RUN, robot), b"\xc1 junk")
                await asyncio.sleep(0.001)
            flooding.set()

    digest, _, agents = attacked(paper, disturb)
    assert flooding.is_set()
    assert digest == expected
    assert sum(agent.complaints.counts["Beacon: recalled"] for agent in agents) > 0


def test_a_flood_of_questions_is_refused_and_changes_no_digit(paper: Scenario, expected: str) -> None:
    refused: list[str] = []

    async def disturb(endpoint: str) -> None:
        questions = [
            (keys.welcome(RUN, "2-3"), messages.encode_join((2, 3))),
            (keys.welcome(RUN, "2-3"), b"\xc1 junk"),
            (keys.welcome(RUN, "2-3"), reversioned(messages.encode_join((2, 3)))),
            (keys.change(RUN), change.encode_change(change.Change("channel.no_such", 1.0))),
            (keys.change(RUN), wire.pack("channel.reference_snr", "NaN")),
            (keys.change(RUN), wire.pack("channel" + ".a" * 1500, "1")),
            (keys.recall(RUN, 4), wire.pack("tick")),
            (keys.recall(RUN, 4), messages.encode_recall(10**9)),
        ]
        async with client(endpoint) as vandal:
            asked = [vandal.ask(*questions[number % len(questions)], 20.0) for number in range(FLOOD // 10)]
            for outcome in await asyncio.gather(*asked, return_exceptions=True):
                assert isinstance(outcome, Refused), outcome
                refused.append(str(outcome))

    digest, server, _ = attacked(paper, disturb)
    assert digest == expected
    assert {
        "robot 2 is hosted by another agent already",
        "Join: is not msgpack (FormatError)",
        "Join: speaks protocol 1, got version: 2",
        "the channel: unknown field 'channel.no_such'; did you mean 'channel.logistic_width'?",
        "Recall: tick must be an integer from 0: 'tick'",
        "robot 4 does not remember its beacon of tick 1000000000",
    } <= set(refused)
    assert {"Join: refused", "Change: refused"} <= set(server.complaints.counts)


def test_more_questions_than_may_wait_are_refused_at_once() -> None:
    async def main() -> list[str]:
        async with session.router() as (world, endpoint), client(endpoint) as asker:
            world.serve("desk", lambda question: question.answer(b"yes", "x"))
            asked = [asyncio.ensure_future(asker.ask("desk", b"", 10.0)) for _ in range(5 * bus.QUESTIONS)]
            await asyncio.sleep(0)  # all are asked
            time.sleep(0.3)  # the loop is busy: none can be answered
            outcomes = await asyncio.gather(*asked, return_exceptions=True)
            return [str(outcome) for outcome in outcomes]

    said = asyncio.run(main())
    assert said.count("b'yes'") == bus.QUESTIONS
    assert said.count("too many questions at once") == 4 * bus.QUESTIONS


def test_ticks_that_come_twice_late_or_early_are_refused_and_change_no_digit(paper: Scenario, expected: str) -> None:
    """What an agent says is said again a little later, as a network that repeats and reorders would."""

    async def disturb(endpoint: str) -> None:
        async with client(endpoint) as echo:
            kept: list[tuple[str, bytes]] = []

            def keep(key: str, payload: bytes | None) -> None:
                if payload is not None and len(kept) < 2000:
                    kept.append((key, payload))

            stop = [echo.subscribe(key(RUN, "*"), keep) for key in (keys.beacon, keys.command, keys.observation)]
            await asyncio.sleep(0.3)
            for undeclare in stop:
                undeclare()
            for key, payload in reversed(kept):
                echo._session.put(key, payload)
            for robot in range(ROBOTS):
                echo._session.put(keys.command(RUN, robot), command(10**6, robot))
                echo._session.put(keys.beacon(RUN, robot), beacon(10**6, robot))
                echo._session.put(keys.observation(RUN, robot), observation(10**6, robot))
            assert kept

    digest, server, agents = attacked(paper, disturb)
    assert digest == expected
    assert server.complaints.counts["Command: is not for this tick"] > 0
    assert all(agent.complaints.counts["Observation: is not for this tick"] for agent in agents)
    assert any(agent.complaints.counts["Beacon: from the future"] for agent in agents)


def test_a_second_command_for_a_tick_is_counted_and_the_first_one_holds() -> None:
    endless = load("pair.toml", run__duration=1000.0)

    async def main() -> None:
        async with session.router() as (opened, endpoint), client(endpoint) as puppet:
            server = Server(opened, endless, "test", RUN, None)
            for robot in (0, 1):
                puppet.token(keys.robot_alive(RUN, robot))
            await server.gather()
            running = asyncio.ensure_future(server.run())
            for linear in (0.0, 50.0, 60.0):  # the last robot is answered for last, so all are of tick 0
                puppet._session.put(keys.command(RUN, 0), command(0, 0, linear))
            puppet._session.put(keys.command(RUN, 1), command(0, 1, 0.0))
            async with asyncio.timeout(5.0):
                while server.summarize() is None:
                    await asyncio.sleep(0.01)
            running.cancel()
            assert server.complaints.counts["Command: came twice"] == 2
            assert server._state.poses[0, :2].tolist() == [0.0, 0.0]  # the pose of pair.toml: it did not move

    asyncio.run(main())


def test_another_run_on_the_same_router_is_not_heard_at_all(paper: Scenario, expected: str) -> None:
    async def disturb(endpoint: str) -> None:
        async with client(endpoint) as vandal:
            for _ in range(20):
                for key, sent in everywhere(b"\xc1 junk", "other"):
                    vandal._session.put(key, sent)
                await asyncio.sleep(0)

    digest, server, agents = attacked(paper, disturb)
    assert digest == expected
    assert not server.complaints.counts
    assert not any(agent.complaints.counts for agent in agents)


def test_a_payload_longer_than_the_limit_does_not_arrive_and_harms_nobody(paper: Scenario, expected: str) -> None:
    async def disturb(endpoint: str) -> None:
        async with client(endpoint) as vandal:
            for key, _ in everywhere(b""):
                vandal._session.put(key, bytes(2 * wire.MAX_PAYLOAD))

    digest, server, agents = attacked(paper, disturb)
    assert digest == expected
    assert not server.complaints.counts
    assert not any(agent.complaints.counts for agent in agents)


def test_who_claims_a_taken_robot_and_leaves_ends_nothing(paper: Scenario, expected: str) -> None:
    """Neither by asking, which is refused, nor by declaring the token of a robot that has one."""

    async def disturb(endpoint: str) -> None:
        for _ in range(3):
            async with client(endpoint) as impostor:
                with pytest.raises(Refused, match="robot 2 is hosted by another agent already"):
                    await impostor.ask(keys.welcome(RUN, "2"), messages.encode_join((2,)), 5.0)
                for robot in (2, 77):
                    impostor.token(keys.robot_alive(RUN, robot))
                await asyncio.sleep(0.02)

    digest, server, _ = attacked(paper, disturb)
    assert digest == expected
    assert server.complaints.counts["Join: refused"] == 3
    assert server.complaints.counts["liveliness: unknown robot"] >= 3


def test_a_key_cannot_forge_a_log_line(paper: Scenario, expected: str, caplog: pytest.LogCaptureFixture) -> None:
    forged = f"fes/{RUN}/robot/1\n2026-01-01 world: all is well\x1b[2J{'x' * 5000}/command"

    async def disturb(endpoint: str) -> None:
        async with client(endpoint) as vandal:
            vandal._session.put(forged, b"\xc1")
            await asyncio.sleep(0.1)

    with caplog.at_level(logging.WARNING):
        digest, server, _ = attacked(paper, disturb)
    assert digest == expected
    assert server.complaints.counts
    assert all(len(line) < 400 and line.isprintable() for line in caplog.messages)


def test_an_observer_shows_what_it_can_read_through_a_flood_of_junk_reports(paper: Scenario, expected: str) -> None:
    seen: list[int] = []

    async def disturb(endpoint: str) -> None:
        async with client(endpoint) as vandal, client(endpoint) as watcher:

            def flood() -> None:
                for _ in range(FLOOD):
                    vandal._session.put(keys.report(RUN), b"\xc1 junk")

            flooding = asyncio.ensure_future(asyncio.to_thread(flood))
            try:
                async for report in observer.reports(watcher, RUN, 5.0, 0.2):
                    if report is not None:
                        seen.append(report.tick)
                        if len(seen) > 1:
                            break
            except (Absent, FesError):
                pass
            await flooding

    digest, _, _ = attacked(paper, disturb)
    assert digest == expected
    assert seen
