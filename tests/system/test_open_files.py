"""Runs with a low limit on open files: the fewest that the doctor accepts suffice, and fewer are one line."""

import resource
import subprocess
import sys
from pathlib import Path

import pytest

from console.doctor import machine
from console.doctor.finding import Status
from tests.support.paths import CONFIGS
from tests.support.processes import PATIENCE, STARTING, fes

PAIR = ["run", str(CONFIGS / "pair.toml"), "--duration", "1", "--headless"]


def limited(files: int, where: Path) -> subprocess.CompletedProcess[str]:
    """Outcome of a run of two processes with a limit of open files per process."""
    words = ["bash", "-c", f'ulimit -n {files} && exec "$@"', "bash", *fes(*PAIR)]
    return subprocess.run(words, cwd=where, capture_output=True, text=True, timeout=PATIENCE)


@pytest.mark.parametrize(
    "files", [machine.LEAST_FILES + 2 * machine.FILES_PER_CHILD + 8, machine.FILES_OF_A_PROCESS + 2 * 2]
)
def test_a_pair_runs_with_few_files(tmp_path: Path, files: int) -> None:
    """Runs with the doctor's limit and with its warning limit. Both have a reserve, as on a busy machine
    robots reconnect."""
    done = limited(files, tmp_path)
    assert (done.returncode, done.stderr) == (0, STARTING.format(2))


def test_a_run_with_too_few_open_files_fails_with_the_command_that_raises_the_limit(tmp_path: Path) -> None:
    done = limited(12, tmp_path)
    assert done.returncode == 1
    least = 18 + 2 * machine.FILES_PER_CHILD
    rule = f"12 per process: 2 robots with a process each take {least}"
    rule += "; raise the hard limit of 12, or --agents-per-process"
    assert done.stderr == f"fes: error: open files: {rule}\n"
    assert not (tmp_path / "runs").exists()


def allow(files: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Set the soft limit of open files; the hard limit is 4,096."""
    monkeypatch.setattr("resource.getrlimit", lambda _: (files, 4096))


@pytest.mark.parametrize(
    ("files", "robots", "status"),
    [
        (64, 2, Status.OK),  # 32 + 2 * 2 = 36
        (35, 2, Status.WARNING),
        (20, 2, Status.WARNING),  # 18 + 2: it runs
        (19, 2, Status.FAILED),
        (28, 10, Status.WARNING),
        (27, 10, Status.FAILED),
        (232, None, Status.OK),  # 32 + 2 * 100
        (231, None, Status.WARNING),
        (12, None, Status.WARNING),
        (resource.RLIM_INFINITY, 1000, Status.OK),
    ],
)
def test_too_few_open_files_are_a_failure_and_few_spare_ones_a_warning(
    files: int, robots: int | None, status: Status, monkeypatch: pytest.MonkeyPatch
) -> None:
    allow(files, monkeypatch)
    monkeypatch.setattr(machine, "FILES_PER_CHILD", 1)  # as before Python 3.12
    result = machine.files(robots)
    assert result.status == status
    assert result.remedy.startswith(f"ulimit -n {32 + 2 * (robots or 100)}, ") == (status != Status.OK)


def test_each_agent_process_takes_two_files_from_python_3_12_on(monkeypatch: pytest.MonkeyPatch) -> None:
    assert (machine.FILES_PER_CHILD == 2) == (sys.version_info >= (3, 12))
    monkeypatch.setattr(machine, "FILES_PER_CHILD", 2)
    for files, status in ((38, Status.WARNING), (37, Status.FAILED)):  # 18 + 2 * 10
        allow(files, monkeypatch)
        assert machine.files(10).status == status
    assert "10 robots with a process each take 38" in machine.files(10).seen


def test_the_remedy_for_too_few_files_respects_the_hard_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    allow(256, monkeypatch)
    assert machine.files(2033).remedy.startswith("raise the hard limit of 4096")  # 32 + 2 * 2033 = 4098


def test_the_doctor_checks_the_limit_that_ulimit_sets() -> None:
    soft, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    seen = machine.files().seen
    assert seen.startswith("no limit" if soft == resource.RLIM_INFINITY else f"{soft} per process")
