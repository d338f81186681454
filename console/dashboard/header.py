"""The first lines of the dashboard: progress and pace of the run, state of the team."""

from collections.abc import Sequence

import numpy as np
from rich.cells import cell_len

from console.dashboard.canvas import Line
from console.dashboard.panels import team_panel
from console.measures import belief, reception
from console.terminal.formatting import count, length, number, styled
from fes.protocol.report import Report
from fes.system.output import printable

_GAP = 3
_LEAST_BAR = 5  # cells of a bar of progress

Facts = list[tuple[str, str, str]]
"""Label, value and style of each fact."""

SILENCE = 1.0
"""Time without a Report [s] after which the world counts as stopped, and its pace is not shown."""


def header(report: Report, width: int, silence: float = 0.0, modes: str = "", source: str = "") -> list[Line]:
    """The two lines, `silence` [s] after the last sign of life of the world.

    `modes` are those of the gates of real robots, `source` is that of the index in words.
    """
    source = source or ("measured" if reception.is_measured(report) else "")
    if report.is_of_robots:
        return [_time(report, width, source), _fitting(_facts_of_robots(report, modes, silence), width)]
    return [_progress(report, width, source), _facts(report, width, silence)]


def _title(report: Report, source: str, room: int) -> Line:
    """The name of the scenario, and the source of the index if there is room."""
    name = printable(report.scenario)
    words = "" if not source or "law" in source else "index "
    if not source or cell_len(name) + 2 + len(words + source) > room:
        return [styled(name, "bold")]
    return [styled(f"{name}  ", "bold"), styled(words, "dim"), styled(source, "cyan")]


def _time(report: Report, width: int, source: str) -> Line:
    time = f"time {number(report.elapsed, ',.1f')} s"
    name = _title(report, source, width - len(time) - 5)
    rule = "─" * max(0, width - _length(name) - len(time) - 2)
    return [*name, styled(f" {rule} ", "dim"), styled(time)]


def _length(line: Line) -> int:
    return sum(segment.cell_length for segment in line)


def _facts_of_robots(report: Report, modes: str, silence: float) -> list[Facts]:
    """The facts about real robots, in their long form and in shorter ones."""
    sent, decoded = report.beacons_sent, report.beacons_decoded
    alive = _living(report)
    estimate = ("mean estimate", length(belief.mean_estimate(report)), "")
    gates = ("gates", modes, "" if "stopped" not in modes and "held" not in modes else "yellow")
    if silence >= SILENCE:
        gates = ("silent for", f"{silence:,.0f} s", "bold red")
    ratio = f"{decoded / sent:.1%}" if sent > 0 else number(float("nan"), "")
    beacons = ("beacons decoded/sent", f"{decoded:,}/{sent:,}, {ratio}", "")
    short = ("decoded", f"{count(decoded)}/{count(sent)}", "")
    long_alive, short_alive = ("robots alive", *alive), ("alive", *alive)
    return [
        [long_alive, gates, estimate, beacons],
        [long_alive, gates, estimate, short],
        [short_alive, gates, estimate],
        [short_alive, gates],
        [short_alive],
    ]


def _progress(report: Report, width: int, source: str) -> Line:
    done, duration = (number(ticks * report.dt, ",.2f") for ticks in (report.tick, report.ticks))
    ticks, times = f"{report.tick:,} / {report.ticks:,}", f"{done} / {duration} s"
    words = [f"tick {ticks}", f"time {times}"] if width >= 72 else [ticks, times]
    taken = sum(len(word) + _GAP for word in words) + 2
    line = _title(report, source, width - taken - _LEAST_BAR)
    room = width - _length(line) - taken
    if room >= _LEAST_BAR:
        part = min(1.0, report.tick / report.ticks) if report.ticks > 0 else 0.0
        full = round(part * room)
        line += [styled("  "), styled("━" * full, "cyan"), styled("─" * (room - full), "dim")]
    return line + [styled(" " * _GAP + word) for word in words]


def _facts(report: Report, width: int, silence: float) -> Line:
    """The facts that fit in `width`, in their short form if necessary."""
    sent, decoded = report.beacons_sent, report.beacons_decoded
    ratio = f"{decoded / sent:.1%}" if sent > 0 else number(float("nan"), "")
    living = _living(report)
    name = "r_β" if len(report.plans) else "r*"
    optimum = (name, f"{number(report.optimal_separation, '.2f')} m", "")
    if report.changed_at > 0.0:
        since = (name, f"{optimum[1]} since {number(report.changed_at, ',.1f')} s", "")
    else:
        since = optimum
    index = [("F of target", team_panel.of_target(report), "")] if report.has_team_index else []
    team, short = [("robots alive", *living), since, *index], [("alive", *living), since, *index]
    pace = [
        ("ticks/s", number(report.ticks_per_s, ",.0f"), ""),
        ("real time", f"×{number(report.ticks_per_s * report.dt, ',.3g')}", ""),
    ]
    if len(report.missed):
        worst = int(np.argmax(report.missed))
        due = max(1, (report.tick + 1) * len(report.missed))
        missed = int(report.missed.sum())
        misses = f"{missed:,}, {missed / due:.2%}" + (f", robot {worst} {report.missed[worst]:,}" if missed else "")
        late = f"{int(report.late.sum()):,}"
        pace = [("live, deadlines missed", misses, "bold red" if missed > due / 1000 else ""), ("late", late, "")]
    if silence >= SILENCE:
        pace = [("stands still for", f"{silence:,.0f} s", "bold red")]
    choices = [
        [*team, *pace, ("beacons decoded/sent", f"{decoded:,}/{sent:,}, {ratio}", "")],
        [*team, *pace, ("decoded/sent", f"{decoded:,}/{sent:,}", "")],
        [*short, *pace, ("decoded", f"{count(decoded)}/{count(sent)}", "")],
        [*short, *pace],
        short,
        [short[0], since],
        [short[0], optimum],
    ]
    return _fitting([*choices, short[:1]], width)


def _living(report: Report) -> tuple[str, str]:
    """Number of robots alive, and its style."""
    n, alive = len(report.alive), int(np.count_nonzero(report.alive == 1))
    return f"{alive}/{n}", "" if alive == n else "bold red"


def _fitting(choices: Sequence[Facts], width: int) -> Line:
    """The first of the choices that fits in `width`, or else the last."""
    facts = next((facts for facts in choices if _extent(facts) <= width), choices[-1])
    line: Line = []
    for label, value, style in facts:
        line += [styled(" " * _GAP if line else ""), styled(f"{label} ", "dim"), styled(value, style)]
    return line


def _extent(facts: Sequence[tuple[str, str, str]]) -> int:
    return sum(len(label) + 1 + len(value) + _GAP for label, value, _ in facts) - _GAP
