"""The dashboard's panel of the team index: F against its target, the robots that cut the links, and the plans."""

import math

import numpy as np
from rich.segment import Segment

from console.dashboard.canvas import Line
from console.measures import team
from console.terminal.formatting import number, percent, styled
from fes.protocol.report import Report

PLANS = ("direct", "contracting", "without a plan")
"""Kind of plan that a robot follows, by its number in the Report."""

_GOOD = 0.99
_MOST = 12  # robots that are named


def panel(report: Report, width: int) -> list[Line]:
    """Three lines, of which the last is empty if no configuration is sought; words that do not fit are omitted."""
    share = report.team_index / report.team_index_target if report.team_index_target > 0.0 else math.nan
    style = "green" if share >= _GOOD else "yellow" if math.isfinite(share) else ""
    values = f"F {number(report.team_index, '.4f')} of {number(report.team_index_target, '.4f')}"
    delivered = f"delivers {percent(report.delivery_after_loss)} after a loss"
    short = f"F {number(report.team_index, '.2f')} of {number(report.team_index_target, '.2f')}"
    index = of_target(report)
    room = width - len(_label("index").text) - len(index) - 2
    text = next((text for text in (f"{values}, {delivered}", values, short) if len(text) <= room), "")
    return [[_label("index"), styled(index, style), styled(f"  {text}")], _cutting(report), _plans(report, width)]


def of_target(report: Report) -> str:
    """The team index as a share of its target."""
    known = report.team_index_target > 0.0
    return percent(report.team_index / report.team_index_target) if known else percent(math.nan)


def _cutting(report: Report) -> Line:
    robots = report.cutting.tolist()
    parts = team.parts(report)
    if parts > 1:
        return [_label("cutting"), styled(f"already cut, into {parts} parts", "bold red")]
    if not robots:
        return [_label("cutting"), styled("no robot", "green")]
    names = ", ".join(map(str, robots[:_MOST])) + (", …" if len(robots) > _MOST else "")
    return [_label("cutting"), styled(f"robot{'s' if len(robots) > 1 else ''} {names}", "yellow")]


def _plans(report: Report, width: int) -> Line:
    if not len(report.plans):
        return []
    present = report.alive == 1
    counts = np.bincount(report.plans[present], minlength=len(PLANS)).tolist()
    words = ", ".join(f"{robots} {name}" for robots, name in zip(counts, PLANS, strict=True) if robots) or "none"
    placed = f"; {int(np.count_nonzero(report.slots[present] >= 0))} with a slot"
    label = _label("plans")
    return [label, styled(words + placed if len(label.text + words + placed) <= width else words)]


def _label(name: str) -> Segment:
    return styled(f"{name:<12}", "dim")
