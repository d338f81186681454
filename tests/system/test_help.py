"""The help of each command: order, sentences, examples, choices and completion."""

import os
import re
import shlex
import subprocess
from pathlib import Path
from typing import Any, get_args

import pytest
import typer

from console import cli, guide
from console.analysis.claims import CLAIMS
from console.sweep.table import Format
from fes.model.config import Clock
from fes.settings import validation
from fes.system import strict_json
from fes.transport import network_flags
from tests.support.commands import PROGRAMS, call
from world.config import builtin
from world.config.outside.schemes import Comparison
from world.config.scenario import Scenario

COMMANDS = {path: line for path, line in guide.EXAMPLES.items() if path not in ("keys", "team")}


def command(path: str) -> Any:
    """The command at a path such as `keys init`."""
    result: Any = typer.main.get_command(cli.app)
    for name in path.split():
        result = result.commands[name]
    return result


def test_the_help_begins_with_run_and_has_a_whole_sentence_for_each_command(tmp_path: Path) -> None:
    text = call(tmp_path, "fes", "--help").stdout
    listed = text.partition("Commands:\n")[2]
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
        assert guide.EXAMPLES[name] in text
    assert "..." not in text.replace("[ARGS]...", "")
    assert "To begin: fes run pair" in text


@pytest.mark.parametrize("path", COMMANDS)
def test_each_command_has_an_example_that_can_be_typed(path: str, tmp_path: Path) -> None:
    example = COMMANDS[path]
    result = command(path)
    assert f"Example: {example}" in result.epilog
    assert result.short_help.endswith(".")
    program, *words = shlex.split(example.partition(" >")[0])
    assert [program, *words[: len(path.split())]] == ["fes", *path.split()]
    result.make_context(path, words[len(path.split()) :])  # raises for an unknown option or argument


@pytest.mark.parametrize("program", ["fes-world", "fes-agent", "fes-robot", "fes-tabletop"])
def test_each_service_has_an_example(program: str, tmp_path: Path) -> None:
    assert f"example: {program} " in call(tmp_path, program, "--help").stdout


CHOICES = {
    "fes run": ["lockstep|live", "processes|inprocess", "max|X"],
    "fes sweep": [f"{'|'.join(form.value for form in Format)}"],
    "fes claims": [", ".join(CLAIMS)],
    "fes-world": ["{router,client,peer}", "max|X"],
    "fes-agent": ["{router,client,peer}"],
    "fes-tabletop": ["{kinematic,mujoco}"],
}
"""Choices in the help, by command."""


@pytest.mark.parametrize("line", CHOICES)
def test_choices_are_named_in_the_help(line: str, tmp_path: Path) -> None:
    text = " ".join(call(tmp_path, *line.split(), "--help").stdout.split())
    for choices in CHOICES[line]:
        assert choices in text


def test_the_help_of_a_clock_has_its_values_and_that_of_set_names_the_schema(tmp_path: Path) -> None:
    assert [clock.value for clock in cli.Clock] == list(get_args(get_args(Clock)[0]))
    assert "fes schema lists them" in " ".join(call(tmp_path, "fes", "run", "--help").stdout.split())


def test_the_help_of_run_lists_the_built_in_scenarios(tmp_path: Path) -> None:
    listed = call(tmp_path, "fes", "run", "--help").stdout.partition("Built-in scenarios:\n")[2]
    assert listed.partition("\n\n")[0].replace(",", " ").split() == builtin.names()


@pytest.mark.parametrize("command", ["view", "set", "doctor"])
def test_flags_of_the_network_are_the_same_in_both_parsers(command: str, tmp_path: Path) -> None:
    texts = [" ".join(call(tmp_path, *line, "--help").stdout.split()) for line in (["fes", command], ["fes-world"])]
    for flag in (network_flags.CONNECT, network_flags.CONFIG, network_flags.CFG):
        assert flag.help in texts[1]
        assert f"{flag.help[0].upper()}{flag.help[1:]}." in texts[0]
        for text in texts:
            assert all(re.search(rf"{name}[ ,]", text) for name in flag.names)


def test_a_shell_completes_the_names_of_scenarios() -> None:
    words = {"_FES_COMPLETE": "complete_bash", "COMP_WORDS": "fes run measured-", "COMP_CWORD": "2"}
    done = subprocess.run([str(PROGRAMS / "fes")], env={**os.environ, **words}, capture_output=True, text=True)
    assert done.stdout.split() == ["measured-coverage", "measured-jump"]


def test_the_shell_completes_commands(tmp_path: Path) -> None:
    asked = {"_FES_COMPLETE": "complete_bash", "COMP_WORDS": "fes r", "COMP_CWORD": "1"}
    done = subprocess.run([str(PROGRAMS / "fes")], env={**os.environ, **asked}, capture_output=True, text=True)
    assert done.stdout.split() == ["run", "replay"]
    assert "--install-completion" in call(tmp_path, "fes", "--help").stdout


def test_the_schema_describes_every_field_of_a_scenario(tmp_path: Path) -> None:
    schema = strict_json.loads(call(tmp_path, "fes", "schema").stdout)
    tables = {"Scenario": schema, **schema["$defs"]}
    fields = {
        (table, name): field for table, result in tables.items() for name, field in result["properties"].items()
    }
    bare = [place for place, field in fields.items() if len(field.get("description", "").split()) < 2]
    assert bare == []
    names = {name for _, name in fields}
    of_schemes = {path.split(".")[-1] for path in validation._fields(Comparison, "")}
    assert names == {path.split(".")[-1] for path in validation._fields(Scenario, "")} | of_schemes
    assert len(fields) > 70
