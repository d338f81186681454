"""Checks that run before a command: other packages with our names, other systems, a missing installation."""

import ast
import shlex
import subprocess
import sys
from importlib import metadata
from pathlib import Path

import pytest

import fes_robots
import world.process
from console import cli
from fes.errors import FesError
from fes.protocol import world_info
from fes.system import distribution, signals
from tests.support.commands import call, complaint, with_path
from tests.support.paths import CONFIGS, ROOT
from tests.support.source import imports

COMMANDS = {
    "fes": ["doctor"], "fes-world": [str(CONFIGS / "pair.toml")], "fes-agent": ["--id", "0"],
    "fes-robot": ["robot.toml"], "fes-tabletop": ["tabletop"],
}  # fmt: skip


@pytest.mark.parametrize("package", distribution.PACKAGES)
@pytest.mark.parametrize("command", COMMANDS)
def test_a_package_that_python_finds_before_ours_ends_every_command_in_one_line(
    command: str, package: str, tmp_path: Path
) -> None:
    (tmp_path / "elsewhere" / package).mkdir(parents=True)
    (tmp_path / "elsewhere" / package / "__init__.py").write_text("raise ImportError('of another project')\n")
    line = complaint(with_path(tmp_path / "elsewhere", tmp_path, command, *COMMANDS[command]), command)
    assert f"the package '{package}' is that of another project: {tmp_path / 'elsewhere' / package}" in line
    assert line.endswith(distribution.separate())


@pytest.mark.parametrize("command", COMMANDS)
def test_an_unknown_core_ends_every_command_in_one_line(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FES_CORE", "rust")
    line = complaint(call(tmp_path, command, *COMMANDS[command]), command)
    assert line == "FES_CORE must be 'c' or 'numpy', got 'rust'"


@pytest.mark.parametrize("module", ["fcntl", "termios", "resource"])
@pytest.mark.parametrize("command", COMMANDS)
def test_a_system_that_is_not_unix_ends_every_command_in_one_line(command: str, module: str, tmp_path: Path) -> None:
    code = f"""
import sys
sys.modules[{module!r}] = None  # as where Python has no such module
sys.argv = {[command, *COMMANDS[command]]!r}
import fes_robots
fes_robots.{command.replace("-", "_")}()
"""
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=tmp_path,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert complaint(done, command) == (
        f"fes runs on Linux and macOS; Python on {sys.platform} has no module '{module}'"
    )


@pytest.mark.parametrize("path", ["fes_robots.py", "fes/system/distribution.py"])
def test_code_that_runs_before_the_package_check_needs_only_the_standard_library(path: str) -> None:
    wanted = set(imports(ast.parse((ROOT / path).read_text(encoding="utf-8"))))
    assert {name.partition(".")[0] for name in wanted} <= sys.stdlib_module_names


def test_the_readme_names_the_systems() -> None:
    assert "Linux or macOS" in (ROOT / "README.md").read_text(encoding="utf-8")


@pytest.fixture
def not_installed(monkeypatch: pytest.MonkeyPatch) -> str:
    """Error of a clone that was updated and not installed again."""
    true = metadata.distribution

    def found(name: str) -> metadata.Distribution:
        if name == distribution.NAME:
            raise metadata.PackageNotFoundError(name)
        return true(name)

    monkeypatch.setattr(metadata, "distribution", found)
    return "fes-robots is not installed here: pip install -e .  # in a clone of fes"


def test_a_clone_that_is_not_installed_is_reported_in_one_line_by_each_program(
    not_installed: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(FesError) as caught:
        world_info.version()
    assert str(caught.value) == not_installed
    assert fes_robots.trouble() == not_installed
    entrances = {"fes": (cli.main, ["--version"]), "fes-world": (world.process.main, [str(CONFIGS / "pair.toml")])}
    for command, (main, words) in entrances.items():
        monkeypatch.setattr(sys, "argv", [command, *words])
        with signals.restored(), pytest.raises(SystemExit) as ended:
            main()
        assert ended.value.code == 1
        out, err = capsys.readouterr()
        assert (out, err) == ("", f"{command}: error: {not_installed}\n")


def test_the_install_command_can_be_pasted_into_a_shell() -> None:
    for command in (distribution.install(), distribution.install("plot"), distribution.separate().partition(": ")[2]):
        subprocess.run(["sh", "-n", "-c", command], check=True)
        assert "clone" not in shlex.split(command, comments=True)
