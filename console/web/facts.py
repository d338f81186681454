"""The header of a page: the facts about a run, as HTML."""

import html
import math
from dataclasses import dataclass

import numpy as np

from console.measures import reception, team
from console.terminal.formatting import UNKNOWN, number, percent
from fes.protocol.report import Report
from fes.system.output import printable

SILENCE = 1.0
"""Time without a report [s] after which a run counts as stopped."""


@dataclass(frozen=True)
class RunFacts:
    """The facts about a run that its reports do not have."""

    run: str
    """Name of the run, or of its log."""
    seed: int | None = None
    """None if the run is announced in another folder."""
    index: str | None = None
    """Source of the index that the robots seek with, in words; None if it is unknown."""


@dataclass(frozen=True)
class Status:
    """State of a run as a page shows it."""

    words: str
    is_warning: bool = False


def live(silence: float, is_over: bool, has_report: bool, left: str) -> Status:
    """The status of a running run, `silence` [s] after its last report; `left` is the reason of its early end."""
    if left:
        return Status(left, True)
    if is_over:
        return Status("the run is over")
    if not has_report:
        return Status("waiting for the world")
    return Status("running") if silence < SILENCE else Status(f"no report for {silence:,.0f} s", True)


def header(report: Report | None, facts: RunFacts, status: Status) -> str:
    """The header as HTML; every text of the run is escaped."""
    state = f'<b class="{"bad" if status.is_warning else "state"}">{_text(status.words)}</b>'
    if report is None:
        content = f"<span>run {_text(facts.run)}</span>{state}"
    else:
        spans = (f"<span>{name} <b>{_text(value)}</b></span>" for name, value in _facts(report, facts))
        content = f"<h1>{_text(report.scenario)}</h1>{state}{''.join(spans)}"
    return f'<div class="facts">{content}</div>'


def kind(report: Report, facts: RunFacts) -> str:
    """The source of the index; unknown without a scenario, until a robot has learnt parameters of the channel."""
    return facts.index or ("measured" if reception.is_measured(report) else UNKNOWN)


def _facts(report: Report, facts: RunFacts) -> list[tuple[str, str]]:
    alive = int(np.count_nonzero(report.alive == 1))
    done, duration = (number(ticks * report.dt, ",.2f") for ticks in (report.tick, report.ticks))
    share = report.beacons_decoded / report.beacons_sent if report.beacons_sent > 0 else math.nan
    optimum = "r_β" if len(report.plans) else "r*"
    items = [
        ("index", kind(report, facts)),
        ("tick", f"{report.tick:,} / {report.ticks:,}"),
        ("time", f"{done} / {duration} s"),
        ("seed", UNKNOWN if facts.seed is None else str(facts.seed)),
        ("run", facts.run),
        ("robots alive", f"{alive} / {len(report.alive)}"),
        (optimum, f"{number(report.optimal_separation, '.2f')} m"),
        ("mean estimate", f"{optimum} {number(report.mean_estimate_error, '+.2f')} m"),
        ("beacons decoded", percent(share)),
        ("pace", f"{number(report.ticks_per_s, ',.0f')} ticks/s, ×{number(report.ticks_per_s * report.dt, ',.3g')}"),
    ]
    if len(report.missed):
        items.append(("deadlines missed", f"{int(report.missed.sum()):,}"))
    if report.has_team_index:
        reached, target = (number(value, ".4f") for value in (report.team_index, report.team_index_target))
        items.append(("team index", f"{reached} of {target}"))
    parts = team.parts(report)
    if parts > 1:
        items.append(("links", f"cut into {parts} parts"))
    elif len(report.cutting):
        items.append(("cutting", ", ".join(map(str, report.cutting[:12].tolist()))))
    return items


def _text(text: str) -> str:
    return html.escape(printable(text))
