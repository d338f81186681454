"""The page of the Python interface, from its signatures and docstrings."""

import inspect
import re
from collections.abc import Callable, Iterator
from typing import Any

import fes
from console.api.result import LinkTable, Run
from console.api.sweep_table import ResultTable, SweepTable
from docs.generators.markdown import code, prose, table
from fes.settings.schema import attribute_docstrings

TITLE = "Python"
INTRODUCTION = """`import fes` offers these functions. The [how-to page](../how-to/python.md) shows them at work. An
error is a `fes.errors.FesError`, one line. Arrays are numpy's. In shapes, `t` is the number of ticks, `n` that of the
robots, and `l` that of the rows of the table of links."""

FUNCTIONS: tuple[Callable[..., Any], ...] = (fes.load, fes.run, fes.read, fes.sweep)
CLASSES: tuple[type, ...] = (Run, LinkTable, SweepTable, ResultTable)

_ARGUMENT = re.compile(r"(\w+): (.*)")


def page() -> list[str]:
    """The lines of the page, without its title."""
    lines: list[str] = []
    for function in FUNCTIONS:
        name = f"fes.{function.__name__}"
        lines += [f"## `{name}`", "", *_call(name, function), *_described(function)]
    for kind in CLASSES:
        name = "fes.Run" if kind is Run else kind.__name__
        members = [*attribute_docstrings(kind).items(), *_members(kind)]
        rows = [[code(member), prose(text)] for member, text in members]
        lines += [f"## `{name}`", "", *_described(kind), *table(["member", "meaning"], rows)]
    return lines


def _call(name: str, function: Callable[..., Any]) -> list[str]:
    """The call with its arguments and their defaults, as Python."""
    arguments = [str(argument.replace(annotation=argument.empty)) for argument in _parameters(function)]
    keyword = [argument.kind is argument.KEYWORD_ONLY for argument in _parameters(function)]
    if any(keyword):
        arguments.insert(keyword.index(True), "*")
    return ["```text", f"{name}({', '.join(arguments)})", "```", ""]


def _parameters(function: Callable[..., Any]) -> list[inspect.Parameter]:
    return list(inspect.signature(function).parameters.values())


def _described(item: object) -> list[str]:
    """A docstring as paragraphs, with its arguments as a table."""
    lines: list[str] = []
    for paragraph in (inspect.getdoc(item) or "").split("\n\n"):
        if paragraph.startswith("Arguments:\n"):
            lines += table(["argument", "meaning"], _arguments(paragraph))
        else:
            lines += [prose(paragraph), ""]
    return lines


def _arguments(paragraph: str) -> list[list[str]]:
    """Name and meaning of each argument; a deeper indentation continues a meaning."""
    entries = re.sub(r"\n {5,}", " ", paragraph).splitlines()[1:]
    matches = [match for entry in entries if (match := _ARGUMENT.fullmatch(entry.strip()))]
    assert len(matches) == len(entries)
    return [[code(match[1]), prose(match[2])] for match in matches]


def _members(kind: type) -> Iterator[tuple[str, str]]:
    """Name and docstring of each public property and method in the body of a class."""
    for name, member in vars(kind).items():
        if name == "__getitem__":
            yield "[column]", inspect.getdoc(member) or ""
        elif not name.startswith("_") and isinstance(member, property):
            yield name, inspect.getdoc(member) or ""
        elif not name.startswith("_") and inspect.isfunction(member):
            arguments = ", ".join(argument.name for argument in _parameters(member)[1:])
            yield f"{name}({arguments})", inspect.getdoc(member) or ""
