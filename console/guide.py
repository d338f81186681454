"""The help of the commands: their order in `fes --help`, a sentence for each, and an example."""

import inspect
import textwrap
from collections.abc import Callable
from typing import Any

import typer
from typer.core import TyperGroup

EXAMPLES = {
    "run": "fes run pair --set run.duration=30",
    "view": "fes view",
    "set": "fes set channel.reference_snr=5e6",
    "replay": "fes replay runs/latest --all",
    "compare": "fes compare runs/paper-1 runs/paper-2",
    "sweep": "fes sweep paper --seeds 0:20 --axis formation.rule=two_nearest,relative_neighborhood",
    "plot": "fes plot runs/latest",
    "fit": "fes fit packets.csv --plot fit.svg",
    "schema": "fes schema > scenario.schema.json",
    "check": "fes check mylab:Mine",
    "doctor": "fes doctor",
    "keys": "fes keys init --robots 2",
    "keys init": "fes keys init --robots 2 --host lab.example",
    "keys issue": "fes keys issue robot-3 --keys keys",
    "keys list": "fes keys list --keys keys",
    "keys rules": "fes keys rules --robots 2 > router.json5",
    "team": "fes team status",
    "team run": "fes team run tabletop --duration 60",
    "team router": "fes team router -l tls/0.0.0.0:7447 --keys keys",
    "team status": "fes team status",
    "team start": "fes team start --robots 0-2",
    "team stop": "fes team stop",
    "team permit": "fes team permit --for 60",
    "team view": "fes team view --record runs/field-1",
    "claims": "fes claims weights",
}
"""Examples by command, in the order of the help."""

_LINES = "\n".join(f"  {example}" for command, example in EXAMPLES.items() if " " not in command)

OVERVIEW = f"\b\nTo begin: fes run pair\nThen:     fes COMMAND --help\n\n\b\nExamples:\n{_LINES}"
"""The end of `fes --help`."""

Command = Callable[..., int]


class CommandsByUse(TyperGroup):
    """Commands in the order of EXAMPLES instead of that of their modules."""

    def list_commands(self, ctx: Any) -> list[str]:
        """The names of the commands, in order."""
        return [name for name in EXAMPLES if name in self.commands]


def listing(title: str, names: list[str]) -> str:
    """A paragraph of help that lists names, none of which is broken at a hyphen."""
    lines = textwrap.wrap(", ".join(names), 76, break_on_hyphens=False)
    return "\n".join(["\b", f"{title}:", *(f"  {line}" for line in lines)])


def command(app: typer.Typer, path: str, paragraph: str = "") -> Callable[[Command], Command]:
    """Register a function as the command at `path`, such as `keys init`.

    Its help is its docstring, then the paragraph, and its example.
    """

    def register(function: Command) -> Command:
        sentence = inspect.getdoc(function).split("\n")[0]  # type: ignore[union-attr]
        texts: dict[str, Any] = {
            "short_help": sentence,
            "epilog": f"{paragraph}\n\n\b\nExample: {EXAMPLES[path]}".lstrip("\n"),
        }
        app.command(name=path.split()[-1], **texts)(function)
        return function

    return register
