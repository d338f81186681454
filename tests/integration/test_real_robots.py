"""A person's side of real robots, over real Zenoh sessions: gates and agents only pretend."""

import asyncio
import contextlib
import io
from collections.abc import AsyncIterator, Awaitable, Callable, Sequence
from pathlib import Path

import pytest
from mcap.reader import make_reader
from rich.console import Console

from console.dashboard import live
from console.dashboard.command import refuse_real_robots
from console.team import command, gates, observer, permit, status
from console.team.merge import Team
from console.team.recorder import NAME, TeamRecorder
from fes.errors import Unavailable
from fes.protocol.report import Report
from fes.protocol.robot_control import RUNNING, STOPPED, GateStatus
from fes.recording.records import Reader
from fes.recording.writer.log_file import LogFile
from fes.system import strict_json
from fes.transport.bus import Bus
from tests.support.fake_robots import FakeGate, report_until_cancelled
from tests.support.processes import PATIENCE
from tests.support.session import RUN, client, router


def run(main: Callable[[], Awaitable[None]]) -> None:
    async def bounded() -> None:
        async with asyncio.timeout(PATIENCE):
            await main()

    asyncio.run(bounded())


async def until(holds: Callable[[], bool]) -> None:
    while not holds():
        await asyncio.sleep(0.005)


@contextlib.asynccontextmanager
async def team(robots: Sequence[int]) -> AsyncIterator[tuple[Bus, str, dict[int, FakeGate]]]:
    """Gates of these robots on a router: their bus, the endpoint for operators, and the gates."""
    async with router() as (opened, endpoint):
        yield opened, endpoint, {robot: FakeGate(opened, RUN, robot) for robot in robots}


@contextlib.asynccontextmanager
async def reporting(bus: Bus, links: dict[int, list[int]], hold: float = 0.0, boot: int = 7) -> AsyncIterator[None]:
    """Reports of robots with these links, at 10 Hz."""
    tasks = [
        asyncio.create_task(report_until_cancelled(bus, RUN, robot, peers, hold, boot))
        for robot, peers in links.items()
    ]
    try:
        yield
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)


def test_started_robots_run_while_the_permit_is_held_and_are_stopped_when_it_ends() -> None:
    async def main() -> None:
        async with team([0, 1, 4]) as (_, endpoint, fakes), client(endpoint) as operator:
            lines: list[str] = []
            robots = await gates.present(operator, RUN)
            assert robots == [0, 1, 4]
            held = asyncio.create_task(permit.start_and_hold(operator, RUN, robots, lines.append))
            await until(lambda: all(fake.mode == RUNNING for fake in fakes.values()))
            await until(lambda: all(f"robot {robot}: running" in lines for robot in robots))
            held.cancel()
            assert await held
            assert [fake.mode for fake in fakes.values()] == [STOPPED] * 3
            assert [fake.asked for fake in fakes.values()] == [["start", "stop"]] * 3
            assert lines[:2] == ["started: 0-1, 4", "the permit is held: Ctrl-C stops the robots"]
            assert lines[-1] == "stopped: 0-1, 4"
            count = len(fakes[0].permits)
            await permit.stop(operator, RUN, robots, lines.append)  # a round trip, in which no Permit arrives
            assert len(fakes[0].permits) == count

    run(main)


def test_robots_are_stopped_even_if_the_operator_leaves_before_they_have_started() -> None:
    async def main() -> None:
        async with team([0]) as (_, endpoint, fakes), client(endpoint) as operator:
            lines: list[str] = []
            held = asyncio.create_task(permit.start_and_hold(operator, RUN, [0], lines.append))
            await until(lambda: bool(fakes[0].permits))
            held.cancel()
            assert not await held  # it was never started
            assert fakes[0].asked == ["stop"]
            assert lines == ["stopped: 0"]

    run(main)


def test_a_robot_without_a_permit_does_not_start_and_the_reason_is_shown() -> None:
    async def main() -> None:
        async with team([0]) as (_, endpoint, fakes), client(endpoint) as operator:
            lines: list[str] = []
            assert not await permit.start(operator, RUN, [0, 1], lines.append)
            assert lines == [
                "robot 0 did not start: stopped, no permit",
                "robot 1 did not start: its gate does not answer",
            ]
            assert fakes[0].asked == ["start"]  # a start is never repeated

    run(main)


def test_a_stop_is_repeated_until_a_gate_confirms_it() -> None:
    async def main() -> None:
        async with router() as (opened, endpoint), client(endpoint) as operator:
            fake, lines = FakeGate(opened, RUN, 3, deaf_to_stops=2), list[str]()
            assert await permit.stop(operator, RUN, [3], lines.append, PATIENCE)
            assert lines == ["stopped: 3"]
            assert fake.asked == ["stop"] * 3

    run(main)


def test_a_robot_that_does_not_confirm_its_stop_is_named_and_the_others_are_stopped() -> None:
    async def main() -> None:
        async with team([0, 2]) as (opened, endpoint, fakes), client(endpoint) as operator:
            FakeGate(opened, RUN, 1, deaf_to_stops=1000)
            lines: list[str] = []
            assert not await permit.stop(operator, RUN, [0, 1, 2, 3], lines.append, 0.5)
            assert lines == [
                "stopped: 0, 2",
                "robot 1 has NOT confirmed its stop: its gate does not answer",
                "robot 3 has NOT confirmed its stop: its gate does not answer",
            ]
            assert [fake.asked for fake in fakes.values()] == [["stop"], ["stop"]]

    run(main)


def test_permits_of_one_operator_rise_and_end_when_their_time_is_over() -> None:
    async def main() -> None:
        async with team([0]) as (_, endpoint, fakes), client(endpoint) as operator:
            await permit.publish(operator, RUN, 7 * permit.PERIOD)
            await permit.stop(operator, RUN, [0], lambda line: None)  # what was published before has arrived
            sequences = [sent.sequence for _, sent in fakes[0].permits]
            assert sequences == sorted(set(sequences))
            assert max(sequences) <= 7
            assert len({sent.operator for _, sent in fakes[0].permits}) == 1

    run(main)


def test_a_gate_lapses_after_the_permit_and_a_new_permit_does_not_start_it() -> None:
    async def main() -> None:
        async with team([0]) as (_, endpoint, fakes), client(endpoint) as operator:
            async with permit.held(operator, RUN):
                assert await permit.start(operator, RUN, [0], lambda line: None)
            await until(lambda: fakes[0].state.mode == STOPPED)
            async with permit.held(operator, RUN):
                [state] = await status.collect(operator, RUN, [0])
                assert gates.words(state.gate) == "stopped, the permit lapsed"

    run(main)


def test_a_stop_of_a_second_operator_wins_while_the_first_holds_the_permit() -> None:
    async def main() -> None:
        async with team([0, 1]) as (_, endpoint, fakes), client(endpoint) as first, client(endpoint) as second:
            lines: list[str] = []
            held = asyncio.create_task(permit.start_and_hold(first, RUN, [0, 1], lines.append))
            await until(lambda: all(f"robot {robot}: running" in lines for robot in (0, 1)))
            assert await permit.stop(second, RUN, [1], lambda line: None)
            await until(lambda: "robot 1: stopped, stopped by the operator" in lines)
            assert fakes[0].mode == RUNNING
            held.cancel()
            assert await held

    run(main)


def test_permits_of_two_operators_differ_in_their_number() -> None:
    async def main() -> None:
        async with (
            team([0]) as (_, endpoint, fakes),
            client(endpoint) as first,
            client(endpoint) as second,
            permit.held(first, RUN),
            permit.held(second, RUN),
        ):
            await until(lambda: len({sent.operator for _, sent in fakes[0].permits}) == 2)

    run(main)


def test_the_status_joins_gate_token_and_report_and_names_an_absent_robot() -> None:
    async def main() -> None:
        async with team([0, 1]) as (opened, endpoint, _), client(endpoint) as person, reporting(opened, {0: [1]}):
            await until_alive(person, [0])
            states = await status.collect(person, RUN, [0, 1, 7])
            assert [isinstance(state.gate, GateStatus) for state in states] == [True, True, False]
            assert [state.is_agent_alive for state in states] == [True, False, False]
            assert [state.report is not None for state in states] == [True, False, False]

    run(main)


async def until_alive(person: Bus, robots: list[int]) -> None:
    """Wait until the reports of these robots arrive."""
    seen = Team(RUN)
    async for report in observer.reports(person, RUN, PATIENCE, seen):
        if report is not None and set(robots) <= set(seen.members):
            return


def test_no_gate_at_all_is_an_error_in_one_line() -> None:
    async def main() -> None:
        async with router() as (_, endpoint), client(endpoint) as operator:
            with pytest.raises(Unavailable, match=f"no gate of run '{RUN}' is alive"):
                await gates.present(operator, RUN)

    run(main)


def test_a_view_of_a_world_refers_to_that_of_a_team_where_only_gates_are_alive() -> None:
    async def main() -> None:
        async with router() as (opened, endpoint), client(endpoint) as person:
            await refuse_real_robots(person, RUN)
            FakeGate(opened, RUN, 0)
            with pytest.raises(Unavailable, match="fes team view shows them"):
                await refuse_real_robots(person, RUN)

    run(main)


def test_an_observer_waits_for_a_robot_until_the_timeout() -> None:
    async def main() -> None:
        async with router() as (_, endpoint), client(endpoint) as person:
            with pytest.raises(Unavailable, match=r"no real robot of run 'test' appeared within 0.3 s"):
                assert [report async for report in observer.reports(person, RUN, 0.3, Team(RUN))] == []

    run(main)


def test_the_dashboard_shows_the_merged_robots_and_the_record_is_a_valid_log(tmp_path: Path) -> None:
    async def main() -> None:
        links = {0: [1], 1: [0, 4], 4: [1]}
        seen: list[Report] = []
        async with (
            team([0, 1, 4]) as (opened, endpoint, _),
            client(endpoint) as person,
            reporting(opened, links, 0.5),
        ):
            robots = Team(RUN)
            screen = live.Screen(Console(width=100, height=30), expected="the robots")
            with TeamRecorder(tmp_path, robots, LogFile) as recorder:
                merged = observer.reports(person, RUN, PATIENCE, robots)
                async for report in command.shown(merged, robots, screen, recorder):
                    if report is not None:
                        screen.history.add(report)
                        seen.append(report)
                    if len(robots.members) == 3 and screen.history.modes == "3 held":
                        break
        console = Console(width=100, record=True, file=io.StringIO())
        console.print(screen.frame())
        text = console.export_text()
        assert "alive 3/5" in text
        assert "gates 3 held" in text
        assert "not alive   2, 3" in text
        assert "0–1" in text
        assert check_log(tmp_path / NAME) == len(seen)
        table = strict_json.loads((tmp_path / "summary.json").read_text())
        assert (table["clock"], table["robots"], table["mean_estimate"]) == ("robots", 3, 68.0)
        assert "digest" not in table
        assert [member["gate"] for member in table["members"]] == ["held"] * 3
        assert [(link["a"], link["b"]) for link in table["links"]] == [(0, 1), (1, 4)]
        assert table["beacons"]["heard"] == seen[-1].beacons_decoded

    run(main)


def check_log(path: Path) -> int:
    """Read a log with this project's reader and with that of mcap; returns its number of reports."""
    reader = Reader(path)
    records = [record for block in reader for record in block]
    assert reader.has_end
    topics: dict[str, int] = {}
    with path.open("rb") as file:
        for _, channel, message in make_reader(file).iter_messages():
            topics[channel.topic] = topics.get(channel.topic, 0) + 1
            assert message.log_time >= 0
    assert sum(topics.values()) == sum(type(record).__name__ == "Message" for record in records)
    assert {"/tf", "/scene/links", "/scene/robots", "/report", "/log"} <= set(topics)
    assert {f"/robot/{robot}/state" for robot in (0, 1, 4)} <= set(topics)
    assert {"/link/0-1/state", "/link/1-4/state"} <= set(topics)
    assert topics["/tf"] == topics["/report"]
    return topics["/report"]


def test_a_robot_that_falls_silent_is_shown_dead_and_alive_again_when_it_reports() -> None:
    async def main() -> None:
        async with team([0, 1]) as (opened, endpoint, _), client(endpoint) as person:
            robots = Team(RUN)
            reports = observer.reports(person, RUN, PATIENCE, robots)
            async with reporting(opened, {0: [1]}):
                async with reporting(opened, {1: [0]}):
                    await alive(reports, [1, 1])
                await alive(reports, [1, 0])
                async with reporting(opened, {1: [0]}, boot=8):
                    await alive(reports, [1, 1])
                assert robots.members[1].starts == 2

    run(main)


async def alive(reports: AsyncIterator[Report | None], expected: list[int]) -> None:
    """Wait for a Report with these robots alive."""
    async for report in reports:
        if report is not None and report.alive.tolist() == expected:
            return
