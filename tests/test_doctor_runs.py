"""fes doctor in a folder whose runs go on, come or were killed: it advises nobody to harm one that goes well."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from console import rundir
from console.doctor import command
from console.doctor.finding import failed
from console.rundir import Address
from fes import keys
from tests.test_cli import call, vacant


def announce(name: str, pid: int) -> Address:
    """A run of the present folder, announced by a process."""
    directory = rundir.ROOT / name
    directory.mkdir(parents=True)
    address = Address(vacant(), keys.DEFAULT_RUN, pid)
    rundir.announce(directory, address)
    return address


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_a_world_that_is_away_while_its_run_goes_on_is_a_warning_that_harms_nobody(tmp_path: Path) -> None:
    here = announce("pair-1", os.getpid())
    (rundir.ROOT / "paper-1").mkdir()
    (rundir.ROOT / rundir.LATEST).symlink_to("paper-1")  # in process, started later, and announced by nobody
    done = call(tmp_path, "fes", "doctor", "--json")
    [found] = [one for one in json.loads(done.stdout) if one["check"] == "endpoint"]
    assert (found["status"], done.returncode) == ("warning", 0)
    assert here.endpoint in found["seen"]
    assert f"process {os.getpid()} goes on with that run, says runs/pair-1/endpoint.json" in found["seen"]
    assert found["remedy"] == "its world is away, suspended or just starting: look again"


def test_a_certificate_that_the_world_refuses_stays_a_failure_while_its_run_goes_on() -> None:
    refused = failed("endpoint", "cannot join: it refuses our certificate: expired", "another certificate")
    assert command.awaited(refused, Path("runs/pair-1/endpoint.json"), Address("tls/x:1", "main", 1)) == refused


def test_a_run_whose_process_was_killed_is_not_announced() -> None:
    gone = subprocess.Popen([sys.executable, "-c", ""])
    gone.wait()
    here = announce("pair-1", os.getpid())
    announce("pair-2", gone.pid)
    (rundir.ROOT / rundir.LATEST).symlink_to("pair-2")
    assert rundir.announced(keys.DEFAULT_RUN) == (Path("runs/pair-1/endpoint.json"), here)
    assert rundir.find(keys.DEFAULT_RUN) == here
    assert rundir.announced("other") is None


def test_a_run_is_announced_by_its_own_directory_and_not_by_the_latest() -> None:
    announce("pair-1", os.getpid())
    (rundir.ROOT / rundir.LATEST).symlink_to("pair-1")
    found = rundir.announced(keys.DEFAULT_RUN)
    assert found is not None
    assert found[0] == Path("runs/pair-1/endpoint.json")
