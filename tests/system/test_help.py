"""The help, read as a newcomer reads it."""

import os
import shlex
import subprocess
from pathlib import Path
from typing import Any, get_args

import pytest
import typer

from console import cli, guide
from fes.model.config import Clock
from fes.system import strict_json
from tests.support.commands import PROGRAMS, call
from world.config import validation
from world.config.scenario import Scenario

COMMANDS = {path: line for path, line in guide.EXAMPLES.items() if path != "keys"}


def command(path: str) -> Any:
    """The command at a path such as `keys init`."""
    found: Any = typer.main.get_command(cli.app)
    for name in path.split():
        found = found.commands[name]
    return found


def test_the_help_begins_with_run_and_has_a_whole_sentence_for_each_command(tmp_path: Path) -> None:
    said = call(tmp_path, "fes", "--help").stdout
    listed = said.partition("Commands:\n")[2]
    names = [line.split()[0] for line in listed.splitlines() if line.startswith("  ") and line[2:3].isalpha()]
    known = [path for path in guide.EXAMPLES if " " not in path]
    assert names[: len(known)] == known
    assert names[0] == "run"
    assert set(known) == set(command("").commands)
    together = " ".join(listed.split())
    for name in known:
        sentence = command(name).short_help or command(name).help
        assert sentence.endswith(".")
        assert f"{name} {sentence}" in together
    assert "..." not in said.replace("[ARGS]...", "")
    assert "To begin: fes run configs/pair.toml" in said


@pytest.mark.parametrize("path", COMMANDS)
def test_each_command_has_an_example_that_can_be_typed(path: str, tmp_path: Path) -> None:
    example = COMMANDS[path]
    found = command(path)
    assert f"Example: {example}" in found.epilog
    assert found.short_help.endswith(".")
    program, *words = shlex.split(example.partition(" >")[0])
    assert [program, *words[: len(path.split())]] == ["fes", *path.split()]
    found.make_context(path, words[len(path.split()) :])  # raises for an unknown option or argument


@pytest.mark.parametrize("program", ["fes-world", "fes-agent"])
def test_each_service_has_an_example(program: str, tmp_path: Path) -> None:
    assert f"example: {program} " in call(tmp_path, program, "--help").stdout


def test_choices_are_named_in_the_help(tmp_path: Path) -> None:
    said = " ".join(call(tmp_path, "fes", "run", "--help").stdout.split())
    assert [one.value for one in cli.Clock] == list(get_args(get_args(Clock)[0]))
    assert "lockstep|live" in said
    assert "processes|inprocess" in said
    assert "fes schema lists them" in said


def test_the_shell_completes_commands(tmp_path: Path) -> None:
    asked = {"_FES_COMPLETE": "complete_bash", "COMP_WORDS": "fes r", "COMP_CWORD": "1"}
    done = subprocess.run([str(PROGRAMS / "fes")], env={**os.environ, **asked}, capture_output=True, text=True)
    assert done.stdout.split() == ["run", "replay"]
    assert "--install-completion" in call(tmp_path, "fes", "--help").stdout


def test_the_schema_describes_every_field_of_a_scenario(tmp_path: Path) -> None:
    schema = strict_json.loads(call(tmp_path, "fes", "schema").stdout)
    tables = {"Scenario": schema, **schema["$defs"]}
    fields = {(table, name): field for table, found in tables.items() for name, field in found["properties"].items()}
    bare = [place for place, field in fields.items() if len(field.get("description", "").split()) < 2]
    assert bare == []
    names = {name for _, name in fields}
    assert names == {path.split(".")[-1] for path in validation._fields(Scenario, "")}
    assert len(fields) > 70
