"""fes doctor in a folder whose runs are running, starting or killed: no remedy harms a healthy run."""

import asyncio
import json
import os
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from console.connect import run_directory
from console.connect.run_directory import Address
from console.doctor import command, network
from console.doctor.finding import Status, failed
from fes.protocol import keys
from fes.transport import connection_diagnosis
from fes.transport.endpoints import Endpoints
from tests.support.commands import call, vacant


def announce(name: str, pid: int) -> Address:
    """A run of the present folder, announced by a process."""
    directory = run_directory.ROOT / name
    directory.mkdir(parents=True)
    address = Address(vacant(), keys.DEFAULT_RUN, pid)
    run_directory.announce(directory, address)
    return address


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_a_world_that_is_away_while_its_run_goes_on_is_a_warning_that_harms_nobody(tmp_path: Path) -> None:
    here = announce("pair-1", os.getpid())
    (run_directory.ROOT / "paper-1").mkdir()
    (run_directory.ROOT / run_directory.LATEST).symlink_to("paper-1")
    # a run in one loop, started later and not announced
    done = call(tmp_path, "fes", "doctor", "--json")
    [found] = [one for one in json.loads(done.stdout) if one["check"] == "endpoint"]
    assert (found["status"], done.returncode) == ("warning", 0)
    assert here.endpoint in found["seen"]
    assert f"by runs/pair-1/endpoint.json, process {os.getpid()} still executes that run" in found["seen"]
    assert found["remedy"] == "its world is starting, suspended or being restarted: check again"


def test_a_certificate_that_the_world_refuses_stays_a_failure_while_its_run_goes_on() -> None:
    refused = failed("endpoint", "cannot join: it refuses our certificate: expired", "another certificate")
    assert (
        command.with_announcement(refused, Path("runs/pair-1/endpoint.json"), Address("tls/x:1", "main", 1))
        == refused
    )


@pytest.mark.parametrize(
    ("flags", "seen", "remedy"),
    [
        (["-e", "bogus"], "not an endpoint like tcp/127.0.0.1:7447: bogus", "fes doctor --help"),
        (
            ["--run", "a b"],
            "a run's name is 1 to 64 letters, digits, '_', '.' or '-', got 'a b'",
            "fes doctor --help",
        ),
        (["--keys", "none"], "--keys none: the observer needs ca.crt, and there is none", "fes doctor -e tls/"),
        (["-e", "tcp/::1:1"], "an IPv6 address needs brackets, tcp/[::1]:1: tcp/::1:1", "fes doctor --help"),
        (["--cfg", "nonsense"], "--cfg expects KEY:VALUE, got 'nonsense'", "fes doctor --help"),
    ],
    ids=lambda given: " ".join(given) if isinstance(given, list) else "",
)
def test_flags_with_which_no_run_can_be_looked_for_are_a_finding_beside_the_others(
    flags: list[str], seen: str, remedy: str, tmp_path: Path
) -> None:
    done = call(tmp_path, "fes", "doctor", "--json", *flags)
    assert (done.returncode, done.stderr) == (1, "")
    found = {one["check"]: one for one in json.loads(done.stdout)}
    assert {"python", "packages", "open files", "loopback", "port", "loopback only"} < set(found)
    assert (found["endpoint"]["status"], found["endpoint"]["seen"]) == ("failed", seen)
    assert found["endpoint"]["remedy"].startswith(remedy)


def test_a_world_that_does_not_say_how_many_robots_it_has_is_no_run_that_is_well() -> None:
    found = network.alive("main", [keys.world_alive("main"), keys.robot_alive("main", 0)], [], None, True)
    assert found.status is Status.WARNING
    assert "robots 0 of ?" in found.seen
    assert network.alive("main", [keys.world_alive("main"), keys.robot_alive("main", 0)], [], 1, True).remedy == ""


@pytest.mark.parametrize("protocol", ["tcp", "tls"])
def test_nobody_is_told_to_start_another_world_where_one_may_be_suspended(protocol: str) -> None:
    """A socket that takes connections and says nothing is what is left of a process that is stopped."""
    with socket.create_server(("127.0.0.1", 0)) as mute:
        endpoint = f"{protocol}/127.0.0.1:{mute.getsockname()[1]}"
        said = connection_diagnosis.complaint(endpoint, {})
        assert said is not None
        assert said.endswith("or it is suspended or overloaded")
        looked = Endpoints("client", (endpoint,), timeout=0.5)
        [found], _ = asyncio.run(network.examine(looked, "main", is_requested=True))
    assert found.status is Status.FAILED
    assert "suspended or overloaded" in found.seen
    assert "check again" in found.remedy
    assert "start" not in found.remedy


def test_a_run_whose_process_was_killed_is_not_announced() -> None:
    gone = subprocess.Popen([sys.executable, "-c", ""])
    gone.wait()
    here = announce("pair-1", os.getpid())
    announce("pair-2", gone.pid)
    (run_directory.ROOT / run_directory.LATEST).symlink_to("pair-2")
    assert run_directory.announced(keys.DEFAULT_RUN) == (Path("runs/pair-1/endpoint.json"), here)
    assert run_directory.find(keys.DEFAULT_RUN) == here
    assert run_directory.announced("other") is None


def test_a_run_is_announced_by_its_own_directory_and_not_by_the_latest() -> None:
    announce("pair-1", os.getpid())
    (run_directory.ROOT / run_directory.LATEST).symlink_to("pair-1")
    found = run_directory.announced(keys.DEFAULT_RUN)
    assert found is not None
    assert found[0] == Path("runs/pair-1/endpoint.json")


def test_a_name_that_does_not_resolve_is_a_finding_with_its_own_remedy(tmp_path: Path) -> None:
    done = call(tmp_path, "fes", "doctor", "--json", "-e", "tcp/no.such.host.invalid:1")
    [found] = [one for one in json.loads(done.stdout) if one["check"] == "endpoint"]
    assert (done.returncode, found["status"]) == (1, "failed")
    assert "the name 'no.such.host.invalid' does not resolve" in found["seen"]
    assert found["remedy"].startswith("correct the name")
