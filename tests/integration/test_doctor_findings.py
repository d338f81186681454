"""fes doctor: findings about a run and their remedies; it neither hangs nor disturbs the run.

Findings about the machine: tests/unit/console/doctor/test_machine.py.
"""

import asyncio
import io
import socket
import time
from typing import Any

import msgpack
import pytest
from rich.console import Console

from console.backends import inprocess
from console.doctor import command, network
from console.doctor.finding import Finding, Status
from console.doctor.network import Answer
from fes.errors import MessageError
from fes.protocol import keys, world_info
from fes.protocol.world_info import WorldInfo
from fes.transport.endpoints import DEFAULT_ENDPOINT, Endpoints, default_endpoint
from tests.support import session
from tests.support.commands import vacant
from tests.support.loop import load
from tests.support.session import RUN, client


def client_of(endpoint: str) -> Endpoints:
    return Endpoints("client", (endpoint,), timeout=network.PATIENCE)


def test_examining_a_run_changes_no_digit_and_sees_every_robot() -> None:
    paper = load("paper.toml", run__duration=2.0)
    seen: list[list[Finding]] = []

    async def disturb(endpoint: str, begin: asyncio.Event) -> None:
        begin.set()
        for _ in range(3):
            findings, robots = await network.examine(client_of(endpoint), RUN, True)
            assert robots == 10
            seen.append(findings)

    async def bounded() -> Any:
        async with asyncio.timeout(60.0):
            return await session.run(paper, [[robot] for robot in range(10)], disturb)

    summary, server, agents = asyncio.run(bounded())
    assert summary["digest"] == inprocess.run(paper, "test")["digest"]
    assert not server.drops.counts
    assert not any(agent.drops.counts for agent in agents)
    for findings in seen:
        assert [finding.check for finding in findings] == ["endpoint", "alive", "version", "world's clock"]
        assert {finding.status for finding in findings} == {Status.OK}  # one clock, one installation
        assert "robots 0-9 of 10" in findings[1].seen


def test_a_missing_robot_is_named() -> None:
    finding = network.alive(RUN, [keys.world_alive(RUN), *(keys.robot_alive(RUN, i) for i in (0, 1, 4))], [], 6, True)
    assert finding.status == Status.WARNING
    effect = "the first tick waits for all robots; later, robots without an agent stand still"
    assert finding.remedy == f"fes-agent --id 2-3, 5: {effect}"
    assert "robots 0-1, 4 of 6" in finding.seen


@pytest.mark.parametrize(
    ("standing", "others", "status", "said"),
    [
        ([], [], Status.FAILED, "no world of run 'test', robots: none"),
        ([keys.robot_alive(RUN, 3)], [], Status.FAILED, "robots: 3"),
        ([], [keys.world_alive("main")], Status.FAILED, "worlds of other runs: main"),
        (
            [keys.world_alive(RUN), keys.claim(RUN, "a"), keys.claim(RUN, "b")],
            [],
            Status.FAILED,
            "more than one world",
        ),
    ],
)
def test_no_world_or_several_worlds_are_a_failure(
    standing: list[str], others: list[str], status: Status, said: str
) -> None:
    finding = network.alive(RUN, standing, others, None, True)
    assert finding.status == status
    assert said in finding.seen
    assert finding.remedy


def test_a_world_of_another_version_is_a_finding_with_both_versions() -> None:
    newer = msgpack.packb([1, "9.0", "3.0", 5, 1.0, "a field more"])
    with pytest.raises(MessageError) as caught:
        world_info.decode_world_info(newer)
    [finding] = network.versions(caught.value)
    assert (finding.status, finding.seen) == (Status.FAILED, "About: speaks protocol 4, got version: 1")
    package, *_ = network.versions(Answer(0.0, 0.0, WorldInfo("0.0.1", "1.0", 3, 0.0)))
    assert package.status == Status.WARNING
    assert "fes 0.0.1" in package.seen


@pytest.mark.parametrize(
    ("offset", "took", "status"),
    [
        (0.05, 0.02, Status.OK),
        (-0.2, 0.02, Status.WARNING),
        (3600.0, 0.02, Status.WARNING),
        (-0.2, 0.4, Status.OK),  # the reply may have been immediate and the query late
    ],
)
def test_clock_skew_is_measured_from_the_middle_of_the_query(offset: float, took: float, status: Status) -> None:
    own = world_info.of_this_process(1)
    *_, finding = network.versions(Answer(100.0, 100.0 + took, own._replace(clock=100.0 + took / 2 + offset)))
    assert finding.status == status
    assert f"{1e3 * offset:+.1f} ms from ours, within {500 * took:.1f} ms" in finding.seen


def test_an_unreachable_endpoint_fails_only_where_a_run_is_expected() -> None:
    for wanted, status in ((True, Status.FAILED), (False, Status.OK)):
        findings, robots = asyncio.run(network.examine(client_of(vacant()), RUN, wanted))
        assert ([finding.status for finding in findings], robots) == ([status], None)


@pytest.mark.parametrize(("wanted", "status"), [(True, Status.FAILED), (False, Status.WARNING)])
def test_a_silent_listener_does_not_delay_the_doctor(wanted: bool, status: Status) -> None:
    with socket.create_server(("127.0.0.1", 0)) as mute:
        begun = time.monotonic()
        endpoints = Endpoints("client", (f"tcp/127.0.0.1:{mute.getsockname()[1]}",), timeout=600.0)
        findings, _ = asyncio.run(network.examine(endpoints, RUN, wanted))
        assert time.monotonic() - begun < endpoints.timeout / 2.0  # Zenoh's own timeout
    assert [(finding.status, bool(finding.remedy)) for finding in findings] == [(status, True)]


def test_a_world_that_does_not_answer_is_a_warning() -> None:
    async def main() -> list[Finding]:
        async with session.router() as (world, endpoint):
            world.declare_token(keys.world_alive(RUN))
            world.declare_queryable(keys.about(RUN), lambda query: None)
            async with client(endpoint):
                return (await network.examine(client_of(endpoint), RUN, True))[0]

    assert [finding.status for finding in asyncio.run(main())][-1] == Status.WARNING


@pytest.mark.parametrize(
    ("endpoint", "table", "status"),
    [
        (DEFAULT_ENDPOINT, "x\n 0: 0100007F:1D17 00000000:0000 0A", Status.OK),  # 7447 = 0x1D17
        (DEFAULT_ENDPOINT, "x\n 0: 00000000:1D17 00000000:0000 0A", Status.WARNING),
        (DEFAULT_ENDPOINT, "x\n 0: 00000000:1D17 00000000:0000 01", Status.OK),  # a connection, no listener
        (DEFAULT_ENDPOINT, "x\n 0: 00000000:1D18 00000000:0000 0A", Status.OK),
        ("tcp/192.0.2.1:7447", "x", Status.WARNING),
        ("unixsock-stream//tmp/fes", "x", Status.OK),
    ],
)
def test_a_listener_on_a_network_is_a_warning(endpoint: str, table: str, status: Status) -> None:
    finding = network.exposure(endpoint, table)
    assert finding.status == status
    assert bool(finding.remedy) == (status != Status.OK)


def test_the_default_address_is_the_same_with_tls() -> None:
    assert network.is_default(DEFAULT_ENDPOINT)
    assert network.is_default(default_endpoint(secure=True))
    assert not network.is_default("tls/127.0.0.1:7448")


def test_a_taken_port_is_a_warning_unless_a_world_has_it() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        endpoint = f"tcp/127.0.0.1:{server.getsockname()[1]}"
        assert network.port(endpoint, world=False).status == Status.WARNING
        assert network.port(endpoint, world=True).status == Status.OK
    assert network.port(endpoint, world=False).status == Status.OK


def test_the_table_fits_eighty_columns() -> None:
    long = Finding("world's clock", Status.WARNING, "x" * 300, "y" * 300)
    screen = Console(width=80, file=io.StringIO())
    screen.print(command.table([long, Finding("port", Status.OK, "free")]))
    assert isinstance(screen.file, io.StringIO)
    lines = screen.file.getvalue().splitlines()
    assert max(map(len, lines)) <= 80
    assert sum(line.count("x") for line in lines[2:]) == 300
    assert sum(line.count("y") for line in lines) == 300
