"""The command fes compare: the first difference of two recorded runs."""

import itertools
from collections.abc import Collection, Iterable, Iterator
from pathlib import Path
from typing import Annotated, Any

import typer

from console.connect.options import Use
from console.replay import log as logs
from console.replay.difference import Difference, between, of_reports, of_summaries
from console.replay.log import Log
from console.terminal import counting, printing, progress
from console.terminal.counting import Watch
from fes import process
from fes.errors import FesError
from fes.protocol import keys
from fes.recording.ticks import LoggedTick
from fes.system import strict_json

MISSING = "nothing"

Setting = tuple[str, Any]
"""Dotted path and value."""


def compare(
    first: Annotated[Path, typer.Argument(metavar="A", help="A log, run.mcap, or a run directory.")],
    second: Annotated[Path, typer.Argument(metavar="B", help="Another log or run directory.")],
    robots: Annotated[
        list[str] | None,
        typer.Option("--robot", metavar="I|A-B", help="Compare only these robots' messages; may be repeated."),
    ] = None,
    use: Use = None,
    json_: Annotated[bool, typer.Option("--json", help="Print only the differences, as JSON.")] = False,
) -> int:
    """Print the first difference of two recorded runs; exit code 1 if they differ, else 0.

    With --robot, scenarios, Reports, summaries and the messages of other robots are not compared.
    """
    first_log, second_log = logs.load(first), logs.load(second)
    chosen = None if robots is None else chosen_robots(robots, first_log.scenario.robots.number)
    lengths = [logs.length(log) for log in (first_log, second_log)]
    passes = [0 if chosen else sum(lengths), max(lengths)]
    with progress.shown("comparing", sum(passes)) as bar:
        of_settings, of_messages = counting.parts(bar, *passes)
        settings = [] if chosen else list(of_scenarios(first_log, second_log, of_settings))
        difference = first_difference(first_log, second_log, chosen, of_messages)
    if json_:
        fields = difference._asdict() if difference else None
        arithmetic = [dict(log.arithmetic) for log in (first_log, second_log)]
        differing = [list(setting) for setting in settings]
        printing.line(strict_json.dumps({"scenario": differing, "first": fields, "arithmetic": arithmetic}))
    else:
        for path, first_value, second_value in settings:
            printing.line(f"scenario, {path}: {first_value!r} in A and {second_value!r} in B")
        scope = f" of robots {', '.join(robots)}" if robots else ""
        same = f"every message{scope} of every tick is the same to the bit"
        printing.line(difference.describe("in A", "in B") if difference else same)
        if difference:
            printing.line(f"A was recorded by {first_log.origin}; B was recorded by {second_log.origin}")
    return process.FAILURE if settings or difference else process.SUCCESS


def of_scenarios(first: Log, second: Log, watch: Watch = counting.ignore) -> Iterator[tuple[str, Any, Any]]:
    """Dotted path and both values of each field in which the scenarios differ.

    A setting at a tick is equal whether it was scheduled or made by an operator. `watch` is called with the ticks
    that were read, of both logs.
    """
    a, b = (
        dict(_fields(log.scenario.model_dump(mode="json", by_alias=True, exclude={"event"}), ""))
        for log in (first, second)
    )
    watches = counting.parts(watch, logs.length(first), 0)
    a["event"], b["event"] = (_events(log, own) for log, own in zip((first, second), watches, strict=True))
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


def first_difference(
    first: Log, second: Log, robots: Collection[int] | None = None, watch: Watch = counting.ignore
) -> Difference | None:
    """The first tick, robot and field in which two logs differ; the end of one log is a difference, too.

    Reports, settings, summaries and ends are compared only if no message differs. With `robots`, only the messages of
    these robots are compared. `watch` is called with the compared ticks.
    """
    deferred, ticks = None, 0
    for pair in itertools.zip_longest(first.ticks(), second.ticks()):
        difference = _of_messages(ticks, *pair, robots)
        if difference is not None:
            return difference
        deferred, ticks = deferred or _beside_messages(ticks, *pair), ticks + 1
        watch(ticks)
    return None if robots else deferred or _of_ends(ticks - 1, first, second)


def _of_messages(
    number: int, first: LoggedTick | None, second: LoggedTick | None, robots: Collection[int] | None
) -> Difference | None:
    if first is None or second is None:
        return Difference(number, "run", None, "this tick", *_presence(first, second))
    return between(number, first.payloads, second.payloads, robots)


def _beside_messages(number: int, first: LoggedTick | None, second: LoggedTick | None) -> Difference | None:
    """The first difference of two ticks with equal messages."""
    assert first is not None
    assert second is not None
    first_settings, second_settings = (_together(tick.scheduled, tick.changes) for tick in (first, second))
    if first_settings != second_settings:
        return Difference(number, "events", None, "what was set", first_settings, second_settings)
    if first.report is None or second.report is None:
        same = first.report is second.report
        return (
            None if same else Difference(number, "Report", None, "payload", *_presence(first.report, second.report))
        )
    return of_reports(first.report, second.report)


def _of_ends(number: int, first: Log, second: Log) -> Difference | None:
    """The first difference of the ends of two logs with equal ticks."""
    if first.ended != second.ended:
        return Difference(number, "end", None, "how it ended", first.ended or MISSING, second.ended or MISSING)
    if first.summary is None or second.summary is None:
        same = first.summary is second.summary
        return None if same else Difference(number, "summary", None, "it", *_presence(first.summary, second.summary))
    return of_summaries(number, first.summary, second.summary)


def _presence(*values: object) -> list[str]:
    return [MISSING if value is None else "there" for value in values]


def _together(scheduled: Iterable[Setting], by_operators: Iterable[Setting]) -> list[Setting]:
    """Settings at a tick, scheduled and by operators: of two values of a field the later."""
    settings: dict[str, Any] = {}
    for path, value in (*scheduled, *by_operators):
        settings.pop(path, None)
        settings[path] = value
    return list(settings.items())


def _events(log: Log, watch: Watch) -> list[dict[str, Any]]:
    """Events of a scenario in which all settings, scheduled and by operators, are scheduled."""
    scenario = log.scenario
    sets = {tick: list(settings.items()) for tick, settings in scenario.changes.items()}
    for number, tick in enumerate(log.ticks(), 1):
        watch(number)
        if tick.changes:
            sets[tick.number] = _together(sets.get(tick.number, ()), tick.changes)
    changes = [
        {"at": round(tick * scenario.run.dt, 9), "set": dict(settings)} for tick, settings in sorted(sets.items())
    ]
    others = [event.model_dump(mode="json", exclude={"settings"}, exclude_defaults=True) for event in scenario.event]
    return changes + [event for event in others if event.keys() - {"at"}]


def _fields(value: Any, path: str) -> Iterator[tuple[str, Any]]:
    """Dotted path and value of each field of a table, and of the tables in it."""
    if isinstance(value, dict):
        for name, inner in value.items():
            yield from _fields(inner, f"{path}.{name}" if path else name)
    else:
        yield path, value
