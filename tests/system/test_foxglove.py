"""`fes view --foxglove` beside a run: the topics of its log, live, and a run that does not notice."""

import asyncio
import math
import signal
import socket
from dataclasses import replace
from pathlib import Path
from typing import Any

from mcap.reader import make_reader

from console.backends import inprocess
from fes.protocol.report import Report, decode_report, encode_report
from fes.recording.layout import NAME
from fes.system import strict_json
from tests.support import foxglove_client, foxglove_layout
from tests.support.commands import call, complaint
from tests.support.foxglove_client import Channel, Client, Received, fields, message_type
from tests.support.foxglove_runs import OUT, SETTINGS, running, viewer
from tests.support.listeners import listening
from tests.support.loop import load
from tests.support.paths import PAIR
from tests.support.processes import PATIENCE
from world.metrics.summary import write_scenario

pytestmark = foxglove_client.needs_foxglove

LAST = 299
"""Last tick of the run."""
DEATH = 20.0
"""Time at which a world dies [s]: ten seconds of wall clock in, so that a viewer is there even on a busy machine."""
LIVE = {"/report", "/tf", "/scene/robots", "/scene/links", "/link/0-1/state"}
"""The topics of a log of two robots that a Report suffices for."""


def at_the_end(client: Client) -> bool:
    return "/report" in client.latest and fields(client.latest["/report"].message)["tick"] == str(LAST)


async def receive(port: int) -> tuple[Client, Client]:
    """A client that receives the run to its end, and one that comes after that."""
    async with foxglove_client.connected(port) as client:
        await client.until(at_the_end)
        await client.until(lambda client: {"/link/0-1/state"} <= client.latest.keys())
    async with foxglove_client.connected(port) as late:
        await late.until(lambda late: late.latest.keys() >= LIVE)
    return client, late


def logged(path: Path) -> tuple[dict[str, Channel], dict[tuple[str, int], bytes]]:
    """The channels of a log, and each payload by its topic and time [ns]."""
    channels, payloads = {}, {}
    with path.open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            assert schema is not None
            channels[channel.topic] = Channel(channel.topic, channel.message_encoding, schema.name, schema.data)
            payloads[channel.topic, message.log_time] = message.data
    return channels, payloads


def without_the_machine(payload: bytes) -> bytes:
    """A Report's payload without the properties of the machine."""
    report: Report = decode_report(payload)
    return encode_report(replace(report, elapsed=math.nan, ticks_per_s=math.nan, alive=0 * report.alive))


def as_logged(received: Received, payload: bytes) -> bool:
    """True if a message is that of the log, but for properties of the machine."""
    if received.topic != "/report":
        return received.payload == payload
    own: Any = received.message
    log = type(own).FromString(payload)
    assert without_the_machine(own.payload) == without_the_machine(log.payload)
    log.payload = own.payload
    return fields(own) == fields(log)


def test_every_channel_has_the_schema_and_the_messages_of_the_log_and_the_digest_is_that_without_a_viewer(
    tmp_path: Path,
) -> None:
    with running(tmp_path, PAIR, *SETTINGS, "--rtf", "4") as run, viewer(tmp_path) as viewing:
        assert listening(viewing.process.pid) == {("127.0.0.1", viewing.port)}
        client, late = asyncio.run(receive(viewing.port))
        output, errors = run.communicate(timeout=PATIENCE)
        assert run.returncode == 0, errors
        assert viewing.line() == f"the run is over after tick {LAST}; its last state stays until Ctrl-C\n"
        viewing.process.send_signal(signal.SIGINT)
        assert viewing.process.communicate(timeout=PATIENCE) == ("", "")
        assert viewing.process.returncode == 0
    channels, payloads = logged(tmp_path / OUT / NAME)
    assert client.channels.keys() == late.channels.keys() == LIVE
    assert client.channels == {topic: channels[topic] for topic in LIVE}
    assert client.latest.keys() == LIVE
    for received in (*client.received, *late.received):
        time = 0 if received.topic == "/scene/robots" else received.time  # a log has it once, at the start
        assert as_logged(received, payloads[received.topic, time]), received.topic
    times = {received.time for received in client.received}
    assert len(times) > 1
    assert times <= set(client.times)
    assert {received.time for received in late.received} == {LAST * 100_000_000}
    kinds = {topic: message_type(channel.schema_name, channel.schema) for topic, channel in client.channels.items()}
    assert foxglove_layout.unknown(kinds) == []
    alone = inprocess.run(load("pair.toml", run__dt=0.1, run__duration=30.0), "pair")
    assert strict_json.loads(output)["digest"] == alone["digest"]


def test_a_viewer_comes_and_leaves_during_a_run_and_another_one_follows_it(tmp_path: Path) -> None:
    async def first(port: int) -> None:
        async with foxglove_client.connected(port) as client:
            await client.until(lambda client: client.latest.keys() >= LIVE)

    settings = ("--set", "run.duration=100000", "--rtf", "1")
    with running(tmp_path, PAIR, *settings) as run:
        for sign in (signal.SIGKILL, signal.SIGTERM):
            with viewer(tmp_path) as viewing:
                asyncio.run(first(viewing.port))
                viewing.process.send_signal(sign)
                viewing.process.communicate(timeout=PATIENCE)
                assert viewing.process.returncode == (0 if sign is signal.SIGTERM else -sign)
        assert run.poll() is None


def test_viewers_follow_a_run_beyond_the_death_of_its_world(tmp_path: Path) -> None:
    scenario = load("neighborhood.toml", run__duration=25.0, event=[{"at": DEATH, "world_away": 0.5}])
    write_scenario(tmp_path, scenario)

    def ticks(client: Client) -> list[int]:
        reports = (received.message for received in client.received if received.topic == "/report")
        return [int(fields(report)["tick"]) for report in reports]

    async def follow(port: int) -> list[int]:
        async with foxglove_client.connected(port) as client:
            await client.until(lambda client: scenario.ticks - 1 in ticks(client))
            return ticks(client)

    with running(tmp_path, "scenario.toml", "--rtf", "2", "--agents-per-process", "5") as run:
        with viewer(tmp_path) as viewing:
            seen = asyncio.run(follow(viewing.port))
        output, errors = run.communicate(timeout=PATIENCE)
    assert run.returncode == 0, errors
    assert min(seen) < DEATH / scenario.run.dt
    assert strict_json.loads(output)["digest"] == inprocess.run(scenario, "scenario")["digest"]


def test_a_port_in_use_is_one_line(tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        done = call(tmp_path, "fes", "view", "--foxglove", "--port", str(port))
    assert complaint(done, "fes") == f"cannot listen at 127.0.0.1:{port}: Address already in use (os error 98)"


def test_flags_that_do_not_fit_are_one_line(tmp_path: Path) -> None:
    alone = call(tmp_path, "fes", "view", "--port", "8765")
    assert complaint(alone, "fes") == "--port is that of --web or --foxglove"
    for words in (["--foxglove", "--picture", "frame.svg"], ["--foxglove", "--web"], ["--web", "--picture", "a.svg"]):
        both = call(tmp_path, "fes", "view", *words)
        assert complaint(both, "fes") == "choose one of --web, --foxglove and --picture"
    for words in ([], ["--foxglove"], ["--picture", "frame.svg"]):
        operator = call(tmp_path, "fes", "view", "--operator", *words)
        assert complaint(operator, "fes") == "--operator goes with --web"


def test_a_run_that_does_not_come_is_one_line(tmp_path: Path) -> None:
    done = call(tmp_path, "fes", "view", "--foxglove", "--port", "0", "--timeout", "0.1", "-e", "tcp/127.0.0.1:1")
    assert done.returncode == 1
    served, error = done.stderr.splitlines()
    assert served.startswith("run 'main' at ws://127.0.0.1:")
    assert error.startswith("fes: error: ")
