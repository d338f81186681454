"""fes check: a check that an extension keeps the rules."""

from typing import Annotated

import typer

from console.check import rules, subject
from console.connect import options
from console.terminal import printing, progress
from fes import process
from world.config.scenario import parse_override


def check(
    extension: Annotated[
        str, typer.Argument(metavar="EXTENSION", help="`module:Class`, or the name of an installed extension.")
    ],
    kind: Annotated[
        str | None,
        typer.Option(metavar="KIND", help=f"Kind, needed if the methods fit several: {', '.join(subject.SLUGS)}."),
    ] = None,
    set_: Annotated[
        list[str] | None, typer.Option("--set", metavar="A=B", help="A parameter of the extension.")
    ] = None,
    use: options.Use = None,
) -> int:
    """Check an extension by short runs: digits, inputs, state, clocks, random numbers.

    Prints one line per rule. The exit code is 1 if the extension breaks a rule.
    """
    parameters = dict(parse_override(text) for text in set_ or ())
    with process.interruptible():
        chosen = subject.of(extension, kind, parameters)
        printing.line(chosen.title)
        is_kept = True
        with progress.drawn("checking", rules.count(chosen), "rules") as watch:
            for number, finding in enumerate(rules.findings(chosen), 1):
                watch(number)
                is_kept &= not finding.failure
                failure = finding.failure.removeprefix(f"{chosen.title}: {finding.rule}: ")
                printing.line(f"{'failed' if failure else 'ok':8}{finding.rule:12}{failure or finding.text}")
    return process.SUCCESS if is_kept else process.FAILURE
