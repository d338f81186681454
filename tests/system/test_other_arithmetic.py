"""Programs with another arithmetic do not mix digits; programs with another numpy or processor agree."""

import json
import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from console.sweep import ledger
from fes.protocol import world_info
from fes.system import fingerprint
from tests.support import arithmetics
from tests.support.arithmetics import NEWER_NUMPY, OTHER
from tests.support.commands import call, complaint, vacant
from tests.support.paths import CONFIGS, PAIR
from tests.support.processes import PATIENCE, command
from tests.support.teams import begun

PAPER = str(CONFIGS / "paper.toml")
HERE, THERE = fingerprint.text(), fingerprint.text(OTHER)
VERSION = world_info.version()
SWEEP = ["sweep", PAIR, "--set", "run.duration=0.2", "--jobs", "1", "--out", "out"]
RECORD = ["run", PAPER, "--duration", "1", "--backend", "inprocess", "--out", "log"]


@pytest.mark.parametrize("environment", arithmetics.SWITCHES, ids=str)
def test_the_fingerprint_is_the_same_with_all_code_paths_of_numpy_and_libm(environment: dict[str, str]) -> None:
    can_be_impossible = "NPY_DISABLE_CPU_FEATURES" in environment  # numpy rejects names that it does not know
    assert arithmetics.of(environment) in {fingerprint.EXPECTED, *([None] if can_be_impossible else [])}


def test_programs_with_another_arithmetic_reject_resumed_runs_and_sweeps(
    tmp_path: Path,
) -> None:
    begun(tmp_path / "run")
    with pytest.MonkeyPatch.context() as changed:
        for name, value in arithmetics.another(tmp_path).items():
            changed.setenv(name, value)
        first = call(tmp_path, "fes", *SWEEP, "--seeds", "0:1")
        resumed = call(tmp_path, "fes-world", "--resume", "run")
    assert first.returncode == 0
    there = OTHER["fingerprint"]
    assert json.loads((tmp_path / "out" / ledger.HEADER).read_text())["arithmetic"] == there
    before = (tmp_path / "out" / ledger.LINES).read_bytes()
    line = complaint(call(tmp_path, "fes", *SWEEP, "--seeds", "0:2"), "fes")
    assert line.endswith(f'sweep.json has arithmetic = "{there}", and this is "{fingerprint.EXPECTED}"')
    assert (tmp_path / "out" / ledger.LINES).read_bytes() == before
    assert complaint(resumed, "fes-world").endswith(
        f"was written by fes {VERSION} with {HERE}; this is fes {VERSION} with {THERE}: the digits would differ"
    )


def test_programs_with_another_numpy_continue_sweeps_and_execute_logs_again(tmp_path: Path) -> None:
    with pytest.MonkeyPatch.context() as changed:
        for name, value in arithmetics.newer_numpy(tmp_path).items():
            changed.setenv(name, value)
        first = call(tmp_path, "fes", *SWEEP, "--seeds", "0:1")
        recorded = call(tmp_path, "fes", *RECORD)
    assert (first.returncode, recorded.returncode) == (0, 0)
    summary = json.loads((tmp_path / "log" / "summary.json").read_text())
    assert summary["arithmetic"] == {**fingerprint.table(), "numpy": NEWER_NUMPY}
    again = call(tmp_path, "fes", "replay", "log", "--all", "--json")
    assert (again.returncode, again.stderr) == (0, "")
    assert json.loads(again.stdout)["arithmetic"]["numpy"] == NEWER_NUMPY != np.__version__
    assert call(tmp_path, "fes", *SWEEP, "--seeds", "0:2").returncode == 0
    assert len((tmp_path / "out" / ledger.LINES).read_bytes().splitlines()) == 2


def test_a_world_names_the_robots_with_another_arithmetic_and_not_those_with_another_numpy(tmp_path: Path) -> None:
    endpoint = vacant()
    environments = {0: arithmetics.newer_numpy(tmp_path), 1: arithmetics.another(tmp_path)}
    words = {robot: command("agents.process", "--id", str(robot), "-e", endpoint) for robot in environments}
    log = tmp_path / "world.log"
    with log.open("wb") as stream:
        world = subprocess.Popen(command("world.process", PAIR, "--duration", "0.2", "-l", endpoint), stderr=stream)
    agents = [
        subprocess.Popen(words[robot], env=os.environ | environment, stderr=subprocess.DEVNULL)
        for robot, environment in environments.items()
    ]
    try:
        assert [process.wait(timeout=PATIENCE) for process in (world, *agents)] == [0, 0, 0]
    finally:
        for process in (world, *agents):
            process.kill()
            process.wait()
    [line] = [line for line in log.read_text().splitlines() if "computed with" in line]
    assert line.endswith(
        f"robots [1] are computed with {THERE}, this world with {HERE}: digits may differ from those of one loop"
    )


def test_figures_of_a_run_with_another_arithmetic_name_both(tmp_path: Path) -> None:
    run = tmp_path / "run"
    done = call(
        tmp_path, "fes", "run", PAIR, "--duration", "0.2", "--backend", "inprocess", "--no-record", "--out", "run"
    )
    assert done.returncode == 0
    summary = json.loads((run / "summary.json").read_text())
    (run / "summary.json").write_text(json.dumps({**summary, "digest": "0" * 64, "arithmetic": OTHER}))
    line = complaint(call(tmp_path, "fes", "plot", "run"), "fes")
    assert line.endswith(
        f"cannot be executed again bit for bit here: it was made with {THERE}; this is fes {VERSION} with {HERE}"
    )
    shutil.rmtree(run)
