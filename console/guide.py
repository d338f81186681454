"""The help of the commands: their order in `fes --help`, a sentence for each, and an example."""

import inspect
from collections.abc import Callable
from typing import Any

import typer
from typer.core import TyperGroup

EXAMPLES = {
    "run": "fes run configs/pair.toml --set run.duration=30",
    "view": "fes view",
    "set": "fes set channel.reference_snr=5e6",
    "replay": "fes replay runs/latest --all",
    "compare": "fes compare runs/paper-1 runs/paper-2",
    "sweep": "fes sweep configs/paper.toml --seeds 0:20 --axis formation.rule=two_nearest,relative_neighborhood",
    "plot": "fes plot runs/latest",
    "schema": "fes schema > scenario.schema.json",
    "doctor": "fes doctor",
    "keys": "fes keys init --robots 2",
    "keys init": "fes keys init --robots 2 --host lab.example",
    "keys issue": "fes keys issue robot-3 --keys keys",
    "keys list": "fes keys list --keys keys",
    "keys rules": "fes keys rules --robots 2 > router.json5",
    "claims": "fes claims weights",
}
"""By command, in the order of the help."""

BEGIN = "\b\nTo begin: fes run configs/pair.toml\nThen:     fes COMMAND --help"

Command = Callable[..., int]


class Ordered(TyperGroup):
    """Commands in the order of EXAMPLES, and not in that of their modules."""

    def list_commands(self, ctx: Any) -> list[str]:
        """The names, in order."""
        return [name for name in EXAMPLES if name in self.commands]


def command(app: typer.Typer, path: str) -> Callable[[Command], Command]:
    """Make a function the command at `path`, such as `keys init`, explained by its docstring and its example."""

    def register(function: Command) -> Command:
        sentence = inspect.getdoc(function).split("\n")[0]  # type: ignore[union-attr]
        given: dict[str, Any] = {"short_help": sentence, "epilog": f"\b\nExample: {EXAMPLES[path]}"}
        app.command(name=path.split()[-1], **given)(function)
        return function

    return register
