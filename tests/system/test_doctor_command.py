"""fes doctor as a command: exit code, table and JSON, for runs that it cannot reach."""

import json
import os
from pathlib import Path

import pytest

from console.connect import run_directory
from console.doctor import network
from console.doctor.finding import Status
from fes.transport.endpoints import DEFAULT_ENDPOINT
from tests.support.announced_runs import announce
from tests.support.commands import call, vacant


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_an_absent_world_of_a_running_run_is_only_a_warning(tmp_path: Path) -> None:
    announced = announce("pair-1", os.getpid())
    (run_directory.ROOT / "paper-1").mkdir()
    (run_directory.ROOT / run_directory.LATEST).symlink_to("paper-1")
    # It runs in one process, was started later, and is not announced.
    done = call(tmp_path, "fes", "doctor", "--json")
    [result] = [finding for finding in json.loads(done.stdout) if finding["check"] == "endpoint"]
    assert (result["status"], done.returncode) == ("warning", 0)
    assert announced.endpoint in result["seen"]
    assert f"according to runs/pair-1/endpoint.json, process {os.getpid()} still executes that run" in result["seen"]
    assert result["remedy"] == "its world is starting, suspended or being restarted: check again"


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
def test_flags_that_name_no_run_are_a_finding_beside_the_others(
    flags: list[str], seen: str, remedy: str, tmp_path: Path
) -> None:
    done = call(tmp_path, "fes", "doctor", "--json", *flags)
    assert (done.returncode, done.stderr) == (1, "")
    result = {finding["check"]: finding for finding in json.loads(done.stdout)}
    assert {"python", "packages", "open files", "loopback", "port", "loopback only"} < set(result)
    assert (result["endpoint"]["status"], result["endpoint"]["seen"]) == ("failed", seen)
    assert result["endpoint"]["remedy"].startswith(remedy)


def test_a_name_that_does_not_resolve_is_a_finding_with_its_own_remedy(tmp_path: Path) -> None:
    done = call(tmp_path, "fes", "doctor", "--json", "-e", "tcp/no.such.host.invalid:1")
    [result] = [finding for finding in json.loads(done.stdout) if finding["check"] == "endpoint"]
    assert (done.returncode, result["status"]) == (1, "failed")
    assert "the name 'no.such.host.invalid' does not resolve" in result["seen"]
    assert result["remedy"].startswith("correct the name")


CHECKS = [
    *("python", "our names", "packages", "arithmetic", "core", "clock", "open files", "run directory"),
    *("loopback", "port", "loopback only", "endpoint"),
]


def test_fes_doctor_prints_json_or_a_table_and_exits_with_1_after_a_failure(tmp_path: Path) -> None:
    endpoint = vacant()
    done = call(tmp_path, "fes", "doctor", "-e", endpoint, "--json")
    assert (done.returncode, done.stderr) == (1, "")
    findings = json.loads(done.stdout)
    assert [finding["check"] for finding in findings if finding["check"] != "extras"] == CHECKS
    assert all(set(finding) == {"check", "status", "seen", "remedy"} for finding in findings)
    assert [finding["check"] for finding in findings if finding["status"] == "failed"] == ["endpoint"]
    assert all(bool(finding["remedy"]) == (finding["status"] != "ok") for finding in findings)
    assert list(tmp_path.iterdir()) == []  # it leaves nothing behind

    healthy = call(tmp_path, "fes", "doctor")
    assert (healthy.returncode, healthy.stderr) == (0, "")
    # A run of the person who tests may have the port.
    taken = network.port(DEFAULT_ENDPOINT, world=False).status == Status.WARNING
    assert taken or "no run is running" in " ".join(healthy.stdout.split())
