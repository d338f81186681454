"""The page of the commands: arguments and flags, from Typer's signatures and argparse's parsers."""

import argparse
import inspect
import typing
from collections.abc import Callable
from enum import EnumMeta
from pathlib import Path
from types import UnionType
from typing import Any, NoReturn

from typer.models import ArgumentInfo, OptionInfo

from agents import process as agent
from console import cli, guide
from docs.generators.markdown import code, table
from fes import command_line
from field import process as robot
from world import process as world
from world.tabletop import process as tabletop

TITLE = "Commands"
INTRODUCTION = """Every command, argument and flag, as `--help` prints them. [Exit codes](exit-codes.md) have a page
of their own."""
HEADS = ["argument or flag", "default", "meaning"]
PLACEHOLDERS = {int: "N", float: "X", str: "TEXT", Path: "PATH"}


def page() -> list[str]:
    """The lines of the page, without its title."""
    lines: list[str] = []
    groups = {info.name: info.typer_instance for info in cli.app.registered_groups}
    for path in guide.EXAMPLES:
        group, _, name = path.rpartition(" ")
        if path in groups:
            first, *others = [of_group.split()[1] for of_group in guide.EXAMPLES if of_group.startswith(f"{path} ")]
            listed = ", ".join(f"`{command}`" for command in others[:-1])
            lines += [f"## fes {path}", "", f"Commands: `{path} {first}`, {listed} and `{others[-1]}`, below.", ""]
            continue
        app = groups[group] if group else cli.app
        assert app is not None
        [callback] = [info.callback for info in app.registered_commands if info.name == name]
        assert callback is not None
        lines += [f"## fes {path}", "", *_text(inspect.getdoc(callback) or ""), *_rows(_signature(callback))]
        lines += [f"Example: `{guide.EXAMPLES[path]}`", ""]
    for parser in map(_parser, (world.main, agent.main, robot.main, tabletop.main)):
        lines += [f"## {parser.prog}", "", *_text(parser.description or ""), *_rows(_arguments(parser))]
        lines += [f"Example: `{(parser.epilog or '').removeprefix('example: ')}`", ""]
    return lines


def _text(docstring: str) -> list[str]:
    return [*inspect.cleandoc(docstring).splitlines(), ""]


def _rows(rows: list[list[str]]) -> list[str]:
    return table(HEADS, rows) if rows else []


def _signature(callback: Callable[..., Any]) -> list[list[str]]:
    hints = typing.get_type_hints(callback, include_extras=True)
    rows = []
    for parameter in inspect.signature(callback).parameters.values():
        kind, *infos = typing.get_args(hints[parameter.name])
        info = next(info for info in infos if isinstance(info, ArgumentInfo | OptionInfo))
        base = _base(kind)
        if isinstance(info, ArgumentInfo):
            shown = info.metavar or parameter.name.strip("_").upper()
        else:
            shown = _flag(info, parameter.name, base, parameter.default)
        rows.append([code(shown), code(_default(parameter.default, base)), info.help or ""])
    return rows


def _base(kind: Any) -> Any:
    """The type of a parameter: `int` of `list[int] | None`."""
    if isinstance(kind, UnionType) or typing.get_origin(kind) is typing.Union:
        [kind] = [part for part in typing.get_args(kind) if part is not type(None)]
    return typing.get_args(kind)[0] if typing.get_origin(kind) is list else kind


def _flag(info: OptionInfo, name: str, base: Any, default: Any) -> str:
    declared = (info.default, *(info.param_decls or ()))  # Typer takes the first one as default, within Annotated
    given = [text for text in declared if isinstance(text, str) and text.startswith("-")]
    plain = f"--{name.strip('_').replace('_', '-')}"
    if base is bool:
        return ", ".join(given) or f"{plain}, --no-{plain[2:]}"
    if info.metavar:
        placeholder = info.metavar
    elif isinstance(base, EnumMeta):
        placeholder = "|".join(str(member.value) for member in base)  # type: ignore[var-annotated]
    else:
        placeholder = PLACEHOLDERS.get(base, "TEXT")
    return f"{', '.join(given) or plain} {placeholder}"


def _default(default: Any, base: Any) -> str:
    if default in (None, inspect.Parameter.empty, False):
        return ""
    return str(getattr(default, "value", default)) if base is not bool else ""


class _Stopped(Exception):
    """Holds the parser of a program whose `main` was stopped when it began to parse."""


def _parser(main: Callable[[], None]) -> argparse.ArgumentParser:
    """The parser that a program makes."""

    def stop(parser: command_line.OneLineParser, *_: object) -> NoReturn:
        raise _Stopped(parser)

    parse = command_line.OneLineParser.parse_args
    command_line.OneLineParser.parse_args = stop  # type: ignore[method-assign,assignment]
    try:
        main()
    except _Stopped as stopped:
        parser: argparse.ArgumentParser = stopped.args[0]
        return parser
    finally:
        command_line.OneLineParser.parse_args = parse  # type: ignore[method-assign]
    raise AssertionError("the program parses no arguments")


def _arguments(parser: argparse.ArgumentParser) -> list[list[str]]:
    rows = []
    for action in parser._actions:
        if action.dest == "help":
            continue
        placeholder = action.metavar or "|".join(map(str, action.choices or ())) or action.dest.upper()
        shown = ", ".join(action.option_strings) or str(action.metavar)
        if action.option_strings and action.nargs != 0:
            shown += f" {placeholder}"
        help_ = (action.help or "").partition(" (default: ")[0]
        default = "" if action.default in (None, False, []) else f"{action.default}"
        rows.append([code(shown), code(default), help_])
    return rows
