"""Installations: a wheel in an environment of its own, and other projects' packages with our names."""

import base64
import hashlib
import json
import shutil
import subprocess
import zipfile
from pathlib import Path

import pytest

from deploy.wheels import contents
from deploy.wheels.platforms import SOURCE
from fes.protocol import world_info
from fes.system import distribution
from tests.support import golden
from tests.support.commands import complaint, with_path
from tests.support.environments import Environment, source_of, wheel_of
from tests.support.paths import ROOT
from world.config import builtin


def wheel_of_another_project(folder: Path) -> Path:
    """The wheel of a project `robot-agents` 1.0, whose one package is called `agents`."""
    world_info = "robot_agents-1.0.dist-info"
    files = {
        "agents/__init__.py": "SOMEBODY_ELSES = True\n",
        f"{world_info}/METADATA": "Metadata-Version: 2.1\nName: robot-agents\nVersion: 1.0\n",
        f"{world_info}/WHEEL": "Wheel-Version: 1.0\nGenerator: test\nRoot-Is-Purelib: true\nTag: py3-none-any\n",
    }
    lines = [f"{name},sha256={_digest(text)},{len(text)}\n" for name, text in files.items()]
    files[f"{world_info}/RECORD"] = "".join([*lines, f"{world_info}/RECORD,,\n"])
    path = folder / "robot_agents-1.0-py3-none-any.whl"
    with zipfile.ZipFile(path, "w") as archive:
        for name, text in files.items():
            archive.writestr(name, text)
    return path


def _digest(text: str) -> str:
    return base64.urlsafe_b64encode(hashlib.sha256(text.encode()).digest()).rstrip(b"=").decode()


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return wheel_of(ROOT, tmp_path_factory.mktemp("wheel"))


@pytest.fixture(scope="module")
def installed(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Environment:
    """An environment outside the clone, with the wheel and no other package of ours."""
    environment = Environment(tmp_path_factory.mktemp("environment"))
    environment.install(wheel)
    return environment


def test_an_installed_wheel_runs_a_built_in_scenario_in_one_loop_and_in_processes(
    installed: Environment, tmp_path: Path
) -> None:
    assert installed.call(tmp_path, "fes", "--version").stdout == f"{world_info.version()}\n"
    assert installed.names(tmp_path)["status"] == "ok"
    assert str(installed.packages) in installed.names(tmp_path)["seen"]
    words = ["fes", "run", "pair", "--duration", "0.5", "--headless", "--json"]
    done = [installed.call(tmp_path, *words, "--backend", backend) for backend in ("inprocess", "processes")]
    assert [run.returncode for run in done] == [0, 0], done
    assert len({json.loads(run.stdout)["digest"] for run in done}) == 1


@pytest.mark.slow
def test_an_installed_wheel_needs_no_clone(installed: Environment, tmp_path: Path) -> None:
    for words in (
        ["run", "paper", "--backend", "inprocess", "--duration", "0.1", "--headless"],
        ["claims", "weights"],
        ["plot", "paper"],
        ["doctor"],
    ):
        done = installed.call(tmp_path, "fes", *words)
        assert done.returncode == 0, (words, done.stdout, done.stderr)
    for program, *words in (["fes", "team", "--help"], ["fes-robot", "--help"], ["fes-tabletop", "--help"]):
        assert installed.call(tmp_path, program, *words).returncode == 0
    summary = json.loads((tmp_path / "runs" / "paper-1" / "summary.json").read_text())
    assert summary["scenario"] == "paper"
    assert (tmp_path / "figures" / "fig5-formation.svg").is_file()


def test_an_unknown_scenario_of_an_installed_wheel_is_reported_in_one_line_with_the_nearest_name(
    installed: Environment, tmp_path: Path
) -> None:
    for program, *words in (
        ["fes", "run", "papr"],
        ["fes-world", "papr"],
        ["fes", "sweep", "papr", "--seeds", "0:2"],
    ):
        line = complaint(installed.call(tmp_path, program, *words), program)
        assert line.startswith("papr: No such file, and not the name of a built-in scenario: the nearest is 'paper'")
        assert "fes run --help lists all of them" in line
    listed = installed.call(tmp_path, "fes", "run", "--help").stdout.partition("Built-in scenarios:\n")[2]
    assert listed.partition("\n\n")[0].replace(",", " ").split() == builtin.names()


def test_a_wheel_holds_each_file_of_its_packages_but_those_in_c(wheel: Path) -> None:
    words = ["git", "ls-files", *distribution.PACKAGES]
    listed = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=True).stdout.splitlines()
    wanted = {name for name in listed if not name.endswith((".c", ".h"))}
    assert {"console/web/page.html", "console/foxglove/layout.json", "field/gate/__main__.py"} <= wanted
    with zipfile.ZipFile(wheel) as archive:
        assert wanted - set(archive.namelist()) == set()


def test_a_wheel_states_its_systems_and_that_it_is_typed(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        [world_info] = [name for name in archive.namelist() if name.endswith("/METADATA")]
        text = archive.read(world_info).decode()
        assert {f"{package}/py.typed" for package in distribution.PACKAGES} <= set(archive.namelist())
    for system in ("MacOS", "POSIX :: Linux"):
        assert f"Classifier: Operating System :: {system}\n" in text


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return source_of(ROOT, tmp_path_factory.mktemp("source"))


def test_the_source_distribution_holds_the_files_in_c_and_nothing_compiled(source: Path) -> None:
    assert contents.problems(source, SOURCE) == []


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler")
def test_an_installation_from_source_builds_the_core_where_a_compiler_is(source: Path, tmp_path: Path) -> None:
    environment = Environment(tmp_path / "venv")
    environment.install(source)
    result = environment.finding(tmp_path, "core")
    assert (result["status"], result["seen"].partition(":")[0]) == ("ok", "compiled")
    assert environment.digest(tmp_path, FES_CORE="c") == environment.digest(tmp_path, FES_CORE="numpy")


def test_an_installation_from_source_without_a_compiler_succeeds_and_the_doctor_warns(
    source: Path, tmp_path: Path
) -> None:
    environment = Environment(tmp_path / "venv")
    environment.install(source, PATH=str(tmp_path))
    assert not list(environment.packages.rglob("core/*.so"))
    result = environment.finding(tmp_path, "core")
    assert (result["status"], result["seen"].partition(": ")[2]) == ("warning", "the compiled core was not built")
    assert "apt-get install gcc" in result["remedy"]
    assert environment.digest(tmp_path) == golden.stored()["pair"]


def test_a_package_of_ours_that_another_project_overwrote_is_a_failure(wheel: Path, tmp_path: Path) -> None:
    environment = Environment(tmp_path / "venv")
    environment.install(wheel)
    environment.install(wheel_of_another_project(tmp_path))
    result = environment.names(tmp_path)
    assert result["status"] == "failed"
    assert "agents/__init__.py is not what fes-robots" in result["seen"]
    assert "robot-agents wrote over it" in result["seen"]
    assert result["remedy"] == distribution.separate()
    assert environment.call(tmp_path, "fes", "doctor").returncode == 1


def test_a_package_of_another_project_that_ours_overwrote_is_a_warning(wheel: Path, tmp_path: Path) -> None:
    environment = Environment(tmp_path / "venv")
    environment.install(wheel_of_another_project(tmp_path))
    environment.install(wheel)
    result = environment.names(tmp_path)
    assert (result["status"], result["seen"]) == ("warning", "robot-agents has the package 'agents' too")
    assert distribution.separate() in result["remedy"]


def test_a_distribution_called_fes_is_a_warning(tmp_path: Path) -> None:
    world_info = tmp_path / "fes-1.0.62.dist-info"
    world_info.mkdir()
    (world_info / "METADATA").write_text("Metadata-Version: 2.1\nName: fes\nVersion: 1.0.62\n")
    output = with_path(tmp_path, tmp_path, "fes", "doctor", "--json").stdout
    [result] = [finding for finding in json.loads(output) if finding["check"] == "our names"]
    assert (result["status"], result["seen"]) == (
        "warning",
        "'fes' 1.0.62 is installed; this project is 'fes-robots'",
    )
    assert "pip uninstall fes" in result["remedy"]
