"""A package of another project that brings one extension of each kind, installed beside the wheel of fes."""

import csv
import json
import shutil
import signal
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from console.backends.process_group import free_port
from tests.support.commands import complaint
from tests.support.environments import Environment, wheel_of
from tests.support.paths import ROOT
from tests.support.processes import PATIENCE, until
from world.execution.checkpoint import FOLDER

OUTSIDE = ROOT / "tests" / "support" / "outside_package"
OWN_LAW = ROOT / "examples" / "own-law"

LAWS = """
schema = 1
[run]
duration = 2.0
seed = 3
[robots]
count = 6
jitter = 5.0
dynamics = "outside_dynamics"
[seeking]
use = "outside_seeking"
target = 70.0
[formation]
rule = "outside_rule"
[formation.law]
use = "outside_formation"
gain = 0.3
[channel]
model = "outside_channel"
[[metric]]
use = "outside_effort"
name = "effort"
[[event]]
at = 0.8
kill = [1]
[[event]]
at = 1.2
restart = [1]
"""
"""Six of the seven kinds; a controller takes the place of the two laws."""

CONTROLLER = LAWS.replace(
    """[seeking]
use = "outside_seeking"
target = 70.0
""",
    "",
).replace(
    """[formation.law]
use = "outside_formation"
gain = 0.3
""",
    """[robots.controller]
use = "outside_controller"
target = 70.0
""",
)

FILES = {"laws": LAWS, "controller": CONTROLLER}

ONE_FILE = """
from fes.extension import NoParameters, Twist


class Circle:
    Parameters = NoParameters

    def __init__(self, parameters, context): ...

    def step(self, robot):
        return Twist(1.0, 0.1)
"""

MACHINE = ("backend", "wall_s", "ticks_per_s", "real_time_factor", "model_free")
"""Keys of a summary that depend on the placement of the robots."""


@pytest.fixture(scope="module")
def environment(tmp_path_factory: pytest.TempPathFactory) -> Environment:
    """An environment with our wheel and that of the other project."""
    folder = tmp_path_factory.mktemp("wheels")
    environment = Environment(tmp_path_factory.mktemp("environment"))
    environment.install(wheel_of(ROOT, folder))
    environment.install(wheel_of(OUTSIDE, folder))
    return environment


def result(environment: Environment, where: Path, *words: str) -> dict[str, Any]:
    """The summary of a run."""
    done = environment.call(where, "fes", "run", *words, "--headless", "--json")
    assert done.returncode == 0, done.stderr
    summary: dict[str, Any] = json.loads(done.stdout)
    return {key: value for key, value in summary.items() if key not in MACHINE}


@pytest.mark.slow
@pytest.mark.parametrize("name", FILES)
def test_extensions_by_entry_point_have_one_digest_in_every_placement(
    environment: Environment, tmp_path: Path, name: str
) -> None:
    (tmp_path / "lab.toml").write_text(FILES[name])
    alone = result(environment, tmp_path, "lab.toml", "--backend", "inprocess")
    assert result(environment, tmp_path, "lab.toml") == alone
    assert result(environment, tmp_path, "lab.toml", "--agents-per-process", "3") == alone
    assert alone["metrics"]["effort"]["total"] > 0.0
    swept = environment.call(tmp_path, "fes", "sweep", "lab.toml", "--seeds", "1:5", "--jobs", "1", "--out", "sweep")
    assert swept.returncode == 0, swept.stderr
    with (tmp_path / "sweep" / "table.csv").open(newline="") as file:
        rows = {row["seed"]: row for row in csv.DictReader(file)}
    assert len({row["digest"] for row in rows.values()}) == 4
    assert rows["3"]["digest"] == alone["digest"]
    assert float(rows["3"]["metrics.effort.total"]) == alone["metrics"]["effort"]["total"]


@pytest.mark.slow
@pytest.mark.parametrize("name", FILES)
def test_a_recorded_run_is_executed_again_only_with_the_same_source(
    environment: Environment, tmp_path: Path, name: str
) -> None:
    (tmp_path / "lab.toml").write_text(FILES[name])
    result(environment, tmp_path, "lab.toml", "--agents-per-process", "3", "--out", "run")
    for words in (["--robot", "1"], ["--all"]):
        done = environment.call(tmp_path, "fes", "replay", "run", *words)
        assert done.returncode == 0, done.stderr
    source = environment.packages / "outside_lab.py"
    text = source.read_text()
    try:
        source.write_text(text + "# changed\n")
        lines = [
            complaint(environment.call(tmp_path, "fes", "replay", "run", *words), "fes")
            for words in (["--robot", "1"], ["--web"])
        ]
    finally:
        source.write_text(text)
    first = {"laws": "neighbor rule 'outside_rule'", "controller": "neighbor rule 'outside_rule'"}[name]
    for line in lines:
        assert line.startswith(f"run/run.mcap: the source of {first} has changed: SHA-256 ")
    assert environment.call(tmp_path, "fes", "replay", "run", "--robot", "1").returncode == 0


@contextmanager
def world(environment: Environment, where: Path, *words: str) -> Iterator[tuple[str, "subprocess.Popen[str]"]]:
    """A world, and the endpoint at which it listens; it is killed at the end of the block."""
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    started = environment.start(where, "fes-world", *words, "-l", endpoint)
    try:
        yield endpoint, started
    finally:
        started.kill()
        started.communicate()


@pytest.mark.slow
def test_an_agent_imports_a_module_that_the_world_names_only_if_it_was_told_to_use_it(
    environment: Environment, tmp_path: Path
) -> None:
    (tmp_path / "mylab.py").write_text(ONE_FILE)
    (tmp_path / "lab.toml").write_text(
        'schema = 1\n[run]\nduration = 0.2\n[robots]\ncount = 2\ncontroller = "mylab:Circle"\n'
    )
    with world(environment, tmp_path, "lab.toml", "--use", "mylab", "--out", "out") as (endpoint, started):
        agent = ["fes-agent", "--id", "0-1", "-e", endpoint]
        refused = environment.call(tmp_path, *agent)
        assert refused.returncode == 1
        assert refused.stderr.splitlines()[-1] == (
            "fes-agent: error: controller 'mylab:Circle': this process was not told to use module 'mylab' "
            "(--use mylab)"
        )
        assert "Traceback" not in refused.stderr
        # until its lease ends, the agent that was refused counts as the host of its robots
        until(lambda: environment.call(tmp_path, *agent, "--use", "mylab").returncode == 0)
        started.communicate(timeout=PATIENCE)
        assert started.returncode == 0
    alone = result(environment, tmp_path, "lab.toml", "--use", "mylab", "--backend", "inprocess")
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["digest"] == alone["digest"]
    line = complaint(environment.call(tmp_path, "fes-world", "lab.toml"), "fes-world")
    assert line == (
        "lab.toml: robots.controller: controller 'mylab:Circle': this process was not told to use module 'mylab' "
        "(--use mylab)"
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", FILES)
def test_a_run_resumed_after_the_death_of_its_world_has_the_same_digest_and_metric(
    environment: Environment, tmp_path: Path, name: str
) -> None:
    (tmp_path / "lab.toml").write_text(FILES[name].replace("duration = 2.0", "duration = 20.0"))
    flags = ["--checkpoint", "0.5", "--rtf", "4"]
    agents: list[subprocess.Popen[str]] = []
    try:
        with world(environment, tmp_path, "lab.toml", "--out", "out", *flags) as (endpoint, killed):
            agents += [
                environment.start(tmp_path, "fes-agent", "--id", ids, "-e", endpoint) for ids in ("0-2", "3-5")
            ]
            state = tmp_path / "out" / FOLDER / "state"
            until(state.exists)
            first = state.stat().st_ino
            until(lambda: state.stat().st_ino != first)
            killed.send_signal(signal.SIGKILL)
            killed.communicate()
        resumed = environment.start(tmp_path, "fes-world", "--resume", "out", "-l", endpoint)
        agents.insert(0, resumed)
        for process in agents:
            _, errors = process.communicate(timeout=PATIENCE)
            assert process.returncode == 0, errors
    finally:
        for process in agents:
            process.kill()
            process.communicate()
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    alone = result(environment, tmp_path, "lab.toml", "--backend", "inprocess")
    assert {key: value for key, value in summary.items() if key not in MACHINE} == {**alone, "scenario": "lab"}


@pytest.mark.slow
def test_the_package_of_the_example_is_installed_and_its_law_runs_by_name_and_passes_its_own_test(
    environment: Environment, tmp_path: Path
) -> None:
    environment.install(wheel_of(OWN_LAW, tmp_path))
    for file in ("lab.toml", "test_own_law.py"):
        shutil.copy(OWN_LAW / file, tmp_path)
    words = ["lab.toml", "--duration", "1.0"]
    alone = result(environment, tmp_path, *words, "--backend", "inprocess")
    assert result(environment, tmp_path, *words, "--agents-per-process", "5") == alone
    done = environment.call(tmp_path, "python", "-m", "pytest", "-q", "-p", "no:cacheprovider", "test_own_law.py")
    assert done.returncode == 0, done.stdout
    assert "2 passed" in done.stdout
    checked = environment.call(tmp_path, "fes", "check", "saturated")
    assert checked.returncode == 0, checked.stdout
    assert checked.stdout.splitlines()[0] == "formation law 'saturated'"
