"""Floods of messages on a running run: surplus messages are dropped, and no digit changes."""

import asyncio
import threading

import pytest
import zenoh

from console.connect import observer
from fes.errors import FesError, Overloaded, Rejected, Unavailable
from fes.protocol import channel_change, keys, messages, wire
from fes.protocol.messages import Join
from fes.transport import bus
from tests.support import session
from tests.support.attackers import (
    FLOOD,
    ROBOTS,
    arrived,
    attacked,
    everywhere,
    put,
    reversioned,
    ticks_go_by,
)
from tests.support.processes import PATIENCE
from tests.support.session import RUN, client


def test_a_flood_of_junk_on_all_keys_at_once_changes_no_digit() -> None:
    async def disturb(endpoint: str, begin: asyncio.Event) -> None:
        targets = everywhere(b"\xc1 junk")

        def flood() -> None:
            for number in range(FLOOD):
                put(vandal, *targets[number % len(targets)])

        async with client(endpoint) as vandal:
            begin.set()
            await asyncio.to_thread(flood)  # as fast as the network accepts it

    server, _ = attacked(disturb)
    # a third of the keys are commands; messages after the end of the run are not counted
    assert 0 < server.drops.counts["Command: is not msgpack (FormatError)"] <= FLOOD


def test_the_lockstep_has_a_priority_of_its_own_and_no_message_of_it_is_dropped() -> None:
    """Puts of Zenoh's tools, of a flood, and of reports use another queue of each link."""
    seen: set[tuple[str, str, str]] = set()

    def note(sample: zenoh.Sample) -> None:
        key = str(sample.key_expr).rpartition("/")[2]
        seen.add((key, str(sample.priority), str(sample.congestion_control)))

    async def disturb(endpoint: str, begin: asyncio.Event) -> None:
        async with client(endpoint) as watcher:
            listening = watcher._session.declare_subscriber(
                f"fes/{RUN}/**", zenoh.handlers.Callback(note, indirect=False)
            )
            await ticks_go_by(watcher, 5, begin)
            report = watcher.declare_publisher(f"fes/{RUN}/no/report", "x", drop=True)
            watcher._session.put(f"fes/{RUN}/no/stranger", b"")
            report(b"")
            await arrived(watcher)
            listening.undeclare()

    attacked(disturb)
    default = str(zenoh.Priority.DATA)
    [priority] = {of for key, of, _ in seen if key not in ("report", "stranger")}
    assert priority != default
    lockstep = {(key, priority, str(zenoh.CongestionControl.BLOCK)) for key in ("observation", "beacon", "command")}
    others = {(key, default, str(zenoh.CongestionControl.DROP)) for key in ("report", "stranger")}
    assert seen == lockstep | others


@pytest.mark.parametrize("size", [1_000, 60_000])
def test_a_flood_that_waits_for_room_closes_no_link_of_a_robot(size: int) -> None:
    """Messages with congestion control BLOCK: two of them stopped a router with two threads."""

    async def disturb(endpoint: str, begin: asyncio.Event) -> None:
        targets = everywhere(bytes(size))[: 3 * ROBOTS]

        def flood() -> None:
            for _ in range(6_000_000 // (size * len(targets)) + 5):
                for key, sent in targets:
                    vandal._session.put(key, sent, congestion_control=zenoh.CongestionControl.BLOCK)

        async with client(endpoint) as vandal:
            begin.set()
            await asyncio.to_thread(flood)

    attacked(disturb)


def test_a_flood_that_pushes_beacons_out_of_full_mailboxes_changes_no_digit(monkeypatch: pytest.MonkeyPatch) -> None:
    """With room for two samples junk displaces nearly every beacon; each is recalled."""
    monkeypatch.setattr(bus, "MAILBOX", 2)
    flooding = asyncio.Event()

    async def disturb(endpoint: str, begin: asyncio.Event) -> None:
        async with client(endpoint) as vandal:
            begin.set()
            for _ in range(150):
                for robot in range(ROBOTS):
                    for _ in range(10):
                        vandal._session.put(keys.beacon(RUN, robot), b"\xc1 junk")
                await asyncio.sleep(0.001)
            flooding.set()

    _, agents = attacked(disturb)
    assert flooding.is_set()
    assert sum(agent.drops.counts["Beacon: recalled"] for agent in agents) > 0


async def _refusal(vandal: bus.Bus, key: str, payload: bytes) -> str:
    """The reason of a query's refusal; the network that it floods may drop an answer, and then it asks again."""
    for _ in range(10):
        try:
            answer = await vandal.get(key, payload, PATIENCE)
        except Rejected as refusal:
            return str(refusal)
        except Unavailable:
            continue
        raise AssertionError(f"the query on {key} has the answer {answer!r}")
    raise AssertionError(f"no answer to ten queries on {key}")


def test_a_flood_of_queries_is_rejected_and_changes_no_digit() -> None:
    refused: list[str] = []

    async def disturb(endpoint: str, begin: asyncio.Event) -> None:
        questions = [
            (keys.welcome(RUN, "2-3"), messages.encode_join(Join((2, 3), 7))),
            (keys.welcome(RUN, "2-3"), b"\xc1 junk"),
            (keys.welcome(RUN, "2-3"), reversioned(messages.encode_join(Join((2, 3), 7)))),
            (keys.change(RUN), channel_change.encode_change(channel_change.ParameterChange("channel.no_such", 1.0))),
            (keys.change(RUN), wire.pack("channel.reference_snr", "NaN")),
            (keys.change(RUN), wire.pack("channel" + ".a" * 1500, "1")),
            (keys.recall(RUN, 4), wire.pack("tick")),
            (keys.recall(RUN, 4), messages.encode_recall(10**9)),
        ]
        async with client(endpoint) as vandal:
            begin.set()
            asked = [_refusal(vandal, *questions[number % len(questions)]) for number in range(FLOOD // 10)]
            refused.extend(await asyncio.gather(*asked))

    server, _ = attacked(disturb)
    assert {
        "robot 2 is hosted by another agent already",
        "Join: is not msgpack (FormatError)",
        "Join: speaks protocol 4, got version: 1",
        "the channel: unknown field 'channel.no_such'; fes schema lists the fields",
        "Recall: tick must be an integer from 0: 'tick'",
        "robot 4 does not remember its beacon of tick 1000000000",
    } <= set(refused)
    assert {"Join: refused", "Change: refused"} <= set(server.drops.counts)


def test_more_queries_than_the_queue_holds_are_rejected_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    refused, refuse = threading.Semaphore(0), bus.Query.reply_err

    def counted(query: bus.Query, reason: str) -> None:
        refuse(query, reason)
        refused.release()

    monkeypatch.setattr(bus.Query, "reply_err", counted)

    async def main() -> list[str]:
        async with session.router() as (world, endpoint), client(endpoint) as asker:
            world.declare_queryable("desk", lambda query: query.reply(b"yes", "x"))
            asked = [asyncio.ensure_future(asker.get("desk", b"", PATIENCE)) for _ in range(5 * bus.MAX_QUERIES)]
            await asyncio.sleep(0)  # all queries are sent
            for _ in range(4 * bus.MAX_QUERIES):  # the loop is busy, so it can answer none
                assert refused.acquire(timeout=PATIENCE)
            outcomes = await asyncio.gather(*asked, return_exceptions=True)
            return [str(outcome) for outcome in outcomes]

    answers = asyncio.run(main())
    assert answers.count("b'yes'") == bus.MAX_QUERIES
    assert answers.count("too many questions at once") == 4 * bus.MAX_QUERIES


def test_agents_that_query_a_new_world_all_at_once_retry(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    busy = 0
    ask = bus.Bus.get

    async def counted(asker: bus.Bus, key: str, payload: bytes, timeout: float) -> bytes:
        nonlocal busy
        try:
            return await ask(asker, key, payload, timeout)
        except Overloaded:
            busy += 1
            raise

    monkeypatch.setattr(bus, "MAX_CLIENTS", 1)
    monkeypatch.setattr(bus.Bus, "get", counted)
    attacked(None)
    assert busy > 0


def test_an_observer_shows_what_it_can_read_through_a_flood_of_junk_reports() -> None:
    seen: list[int] = []

    async def disturb(endpoint: str, begin: asyncio.Event) -> None:
        async with client(endpoint) as vandal, client(endpoint) as watcher:
            begin.set()

            def flood() -> None:
                for number in range(FLOOD):
                    vandal._session.put(keys.report(RUN), (b"\xc1 junk", b"\x92\x02\x00")[number % 2])

            flooding = asyncio.ensure_future(asyncio.to_thread(flood))
            try:
                async for report in observer.reports(watcher, RUN, PATIENCE, 0.2):
                    if report is not None:
                        seen.append(report.tick)
                        if len(seen) > 1:
                            break
            except (Unavailable, FesError):
                pass
            await flooding

    attacked(disturb)
    assert seen
