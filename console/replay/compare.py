"""The command fes compare: where two recorded runs first differ."""

import itertools
from collections.abc import Collection, Iterable, Iterator
from pathlib import Path
from typing import Annotated, Any

import typer

from console.replay import log as logs
from console.replay.difference import Difference, between, of_reports, of_summaries
from console.replay.log import Log
from console.terminal import printing, progress
from fes import process
from fes.errors import FesError
from fes.protocol import keys
from fes.recording.ticks import LoggedTick
from fes.system import fingerprint, strict_json

MISSING = "nothing"

Setting = tuple[str, Any]
"""Dotted path and value."""


def compare(
    first: Annotated[Path, typer.Argument(metavar="A", help="A log, run.mcap, or a run directory.")],
    second: Annotated[Path, typer.Argument(metavar="B", help="Another one.")],
    robots: Annotated[
        list[str] | None,
        typer.Option("--robot", metavar="I|A-B", help="Compare only these robots' messages; may be repeated."),
    ] = None,
    json_: Annotated[bool, typer.Option("--json", help="Print the differences as JSON, and nothing else.")] = False,
) -> int:
    """Say where two recorded runs first differ: exit code 0 if they do not, 1 if they do.

    With --robot the scenarios, Reports and summaries may differ, and so may what other robots sense and say.
    """
    one, other = logs.load(first), logs.load(second)
    chosen = None if robots is None else chosen_robots(robots, one.scenario.robots.number)
    with progress.bar("compared"):
        settings = [] if chosen else list(of_scenarios(one, other))
        found = first_difference(one, other, chosen)
    if json_:
        told = found._asdict() if found else None
        arithmetic = [dict(log.arithmetic) for log in (one, other)]
        differing = [list(setting) for setting in settings]
        printing.line(strict_json.dumps({"scenario": differing, "first": told, "arithmetic": arithmetic}))
    else:
        for path, mine, theirs in settings:
            printing.line(f"scenario, {path}: {mine!r} in A and {theirs!r} in B")
        whose = f" of robots {', '.join(robots)}" if robots else ""
        same = f"every message{whose} of every tick is the same to the bit"
        printing.line(found.told("in A", "in B") if found else same)
        if found:
            a, b = (fingerprint.text(log.arithmetic) for log in (one, other))
            printing.line(f"A was recorded with {a}; B was recorded with {b}")
    return process.FAILURE if settings or found else process.SUCCESS


def of_scenarios(one: Log, other: Log) -> Iterator[tuple[str, Any, Any]]:
    """Dotted path and both values of each field in which the scenarios differ.

    What was set at a tick is the same whether it was scheduled or a person set it.
    """
    a, b = (
        dict(_fields(log.scenario.model_dump(mode="json", by_alias=True, exclude={"event"}), ""))
        for log in (one, other)
    )
    a["event"], b["event"] = _events(one), _events(other)
    for path in [*a, *(path for path in b if path not in a)]:
        values = a.get(path, MISSING), b.get(path, MISSING)
        if values[0] != values[1]:
            yield path, *values


def chosen_robots(texts: Iterable[str], robots: int) -> set[int]:
    """The robots that `I` and `A-B` name in a team of `robots`; raises FesError."""
    chosen = {robot for text in texts for robot in keys.parse_span(text, "--robot")}
    unknown = sorted(robot for robot in chosen if robot >= robots)
    if unknown:
        raise FesError(f"--robot {unknown[0]}: the runs have robots 0 to {robots - 1}")
    return chosen


def first_difference(one: Log, other: Log, robots: Collection[int] | None = None) -> Difference | None:
    """The first tick, robot and field in which two logs differ; the end of one of them is a difference, too.

    Reports, settings, summaries and ends are compared only if no message differs. With `robots` only their messages
    are compared.
    """
    aside, ticks = None, 0
    for pair in itertools.zip_longest(one.ticks(), other.ticks()):
        found = _of_messages(ticks, *pair, robots)
        if found is not None:
            return found
        aside, ticks = aside or _aside(ticks, *pair), ticks + 1
    return None if robots else aside or _of_ends(ticks - 1, one, other)


def _of_messages(
    number: int, one: LoggedTick | None, other: LoggedTick | None, robots: Collection[int] | None
) -> Difference | None:
    if one is None or other is None:
        return Difference(number, "run", None, "this tick", *_there(one, other))
    return between(number, one.payloads, other.payloads, robots)


def _aside(number: int, one: LoggedTick | None, other: LoggedTick | None) -> Difference | None:
    """The first difference of two ticks whose messages are the same."""
    assert one is not None
    assert other is not None
    mine, theirs = (_together(tick.scheduled, tick.changes) for tick in (one, other))
    if mine != theirs:
        return Difference(number, "events", None, "what was set", mine, theirs)
    if one.report is None or other.report is None:
        same = one.report is other.report
        return None if same else Difference(number, "Report", None, "payload", *_there(one.report, other.report))
    return of_reports(one.report, other.report)


def _of_ends(number: int, one: Log, other: Log) -> Difference | None:
    """How the ends of two logs differ whose ticks are the same."""
    if one.ended != other.ended:
        return Difference(number, "end", None, "how it ended", one.ended or MISSING, other.ended or MISSING)
    if one.summary is None or other.summary is None:
        same = one.summary is other.summary
        return None if same else Difference(number, "summary", None, "it", *_there(one.summary, other.summary))
    return of_summaries(number, one.summary, other.summary)


def _there(*things: object) -> list[str]:
    return [MISSING if thing is None else "there" for thing in things]


def _together(scheduled: Iterable[Setting], by_persons: Iterable[Setting]) -> list[Setting]:
    """What was set at a tick, by whomever: of two values of a field the later one."""
    found: dict[str, Any] = {}
    for path, value in (*scheduled, *by_persons):
        found.pop(path, None)
        found[path] = value
    return list(found.items())


def _events(log: Log) -> list[dict[str, Any]]:
    """What was scheduled or set, as the events of a scenario in which all of it is scheduled."""
    scenario = log.scenario
    sets = {tick: list(settings.items()) for tick, settings in scenario.changes.items()}
    for tick in log.ticks():
        if tick.changes:
            sets[tick.number] = _together(sets.get(tick.number, ()), tick.changes)
    found = [
        {"at": round(tick * scenario.run.dt, 9), "set": dict(settings)} for tick, settings in sorted(sets.items())
    ]
    return found + [
        {"at": event.at, "kill": event.kill, "restart": event.restart}
        for event in scenario.event
        if event.kill or event.restart
    ]


def _fields(value: Any, path: str) -> Iterator[tuple[str, Any]]:
    """Dotted path and value of each field of a table, and of the tables in it."""
    if isinstance(value, dict):
        for name, inner in value.items():
            yield from _fields(inner, f"{path}.{name}" if path else name)
    else:
        yield path, value
