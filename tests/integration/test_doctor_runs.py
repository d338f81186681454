"""fes doctor in a folder with running, starting and killed runs: no advice harms a healthy run."""

import asyncio
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
from tests.support.announced_runs import announce


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_a_certificate_that_the_world_rejects_stays_a_failure_during_its_run() -> None:
    refused = failed("endpoint", "cannot join: it refuses our certificate: expired", "another certificate")
    assert (
        command.with_announcement(refused, Path("runs/pair-1/endpoint.json"), Address("tls/x:1", "main", 1))
        == refused
    )


def test_a_world_that_does_not_report_its_number_of_robots_is_a_finding() -> None:
    finding = network.alive("main", [keys.world_alive("main"), keys.robot_alive("main", 0)], [], None, True)
    assert finding.status is Status.WARNING
    assert "robots 0 of ?" in finding.seen
    assert network.alive("main", [keys.world_alive("main"), keys.robot_alive("main", 0)], [], 1, True).remedy == ""


@pytest.mark.parametrize("protocol", ["tcp", "tls"])
def test_the_doctor_does_not_advise_a_second_world_where_one_may_be_suspended(protocol: str) -> None:
    """A suspended process still accepts connections, and does not answer."""
    with socket.create_server(("127.0.0.1", 0)) as mute:
        endpoint = f"{protocol}/127.0.0.1:{mute.getsockname()[1]}"
        complaint = connection_diagnosis.complaint(endpoint, {})
        assert complaint is not None
        assert complaint.endswith("or it is suspended or overloaded")
        looked = Endpoints("client", (endpoint,), timeout=0.5)
        [finding], _ = asyncio.run(network.examine(looked, "main", is_requested=True))
    assert finding.status is Status.FAILED
    assert "suspended or overloaded" in finding.seen
    assert "check again" in finding.remedy
    assert "start" not in finding.remedy


def test_a_run_whose_process_was_killed_is_not_announced() -> None:
    gone = subprocess.Popen([sys.executable, "-c", ""])
    gone.wait()
    announced = announce("pair-1", os.getpid())
    announce("pair-2", gone.pid)
    (run_directory.ROOT / run_directory.LATEST).symlink_to("pair-2")
    assert run_directory.announced(keys.DEFAULT_RUN) == (Path("runs/pair-1/endpoint.json"), announced)
    assert run_directory.find(keys.DEFAULT_RUN) == announced
    assert run_directory.announced("other") is None


def test_a_run_is_announced_by_its_own_directory_and_not_by_the_latest() -> None:
    announce("pair-1", os.getpid())
    (run_directory.ROOT / run_directory.LATEST).symlink_to("pair-1")
    announced = run_directory.announced(keys.DEFAULT_RUN)
    assert announced is not None
    assert announced[0] == Path("runs/pair-1/endpoint.json")
