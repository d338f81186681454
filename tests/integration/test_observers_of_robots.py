"""Observers of real robots, over real Zenoh sessions: status, merged reports, dashboard and record."""

import io
from collections.abc import AsyncIterator
from pathlib import Path

import pytest
from mcap.reader import make_reader
from rich.console import Console

from console.dashboard import live
from console.dashboard.command import refuse_real_robots
from console.team import command, observer, status
from console.team.merge import Team
from console.team.recorder import NAME, TeamRecorder
from fes.errors import Unavailable
from fes.protocol.report import Report
from fes.protocol.robot_control import GateStatus
from fes.recording.records import Reader
from fes.recording.writer.log_file import LogFile
from fes.system import strict_json
from fes.transport.bus import Bus
from tests.support.fake_robots import FakeGate
from tests.support.processes import PATIENCE
from tests.support.robot_sessions import gated, reporting, run
from tests.support.session import RUN, client, router


def test_the_status_joins_gate_token_and_report_and_names_an_absent_robot() -> None:
    async def main() -> None:
        async with gated([0, 1]) as (opened, endpoint, _), client(endpoint) as person, reporting(opened, {0: [1]}):
            async with client(endpoint) as another:
                await until_alive(another, [0])
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
            gated([0, 1, 4]) as (opened, endpoint, _),
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
        async with gated([0, 1]) as (opened, endpoint, _), client(endpoint) as person:
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
