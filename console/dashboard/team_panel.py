"""The dashboard's panel of the team index: F against its target, the robots that cut the links, and the plans."""

import math

import numpy as np

from console.dashboard.canvas import Line
from console.measures import team
from console.terminal.formatting import number, percent, styled
from fes.protocol.report import Report

PLANS = ("direct", "contracting", "without a plan")
"""Kind of plan that a robot follows, by its number in the Report."""

_GOOD = 0.99
_MOST = 12  # robots that are named


def panel(report: Report, width: int) -> list[Line]:
    """Three lines; the last one is empty if no configuration is sought."""
    share = report.team_index / report.team_index_target if report.team_index_target > 0.0 else math.nan
    style = "green" if share >= _GOOD else "yellow" if math.isfinite(share) else ""
    values = f"F {number(report.team_index, '.4f')} of {number(report.team_index_target, '.4f')}"
    delivered = f"delivers {percent(report.delivery_after_loss)} after a loss"
    first: Line = [styled("index       ", "dim"), styled(of_target(report), style), styled(f"  {values}")]
    if sum(segment.cell_length for segment in first) + len(delivered) + 2 <= width:
        first.append(styled(f", {delivered}"))
    return [first, _cutting(report), _plans(report)]


def of_target(report: Report) -> str:
    """The team index as a share of its target."""
    known = report.team_index_target > 0.0
    return percent(report.team_index / report.team_index_target) if known else percent(math.nan)


def _cutting(report: Report) -> Line:
    robots = report.cutting.tolist()
    parts = team.parts(report)
    if parts > 1:
        return [styled("cutting     ", "dim"), styled(f"the links are already cut, into {parts} parts", "bold red")]
    if not robots:
        return [styled("cutting     ", "dim"), styled("no robot", "green")]
    names = ", ".join(map(str, robots[:_MOST])) + (", …" if len(robots) > _MOST else "")
    label = styled("cutting     ", "dim")
    return [label, styled(f"robot{'s' if len(robots) > 1 else ''} {names}", "yellow")]


def _plans(report: Report) -> Line:
    if not len(report.plans):
        return []
    present = report.alive == 1
    counts = np.bincount(report.plans[present], minlength=len(PLANS)).tolist()
    words = ", ".join(f"{robots} {name}" for robots, name in zip(counts, PLANS, strict=True) if robots)
    placed = int(np.count_nonzero(report.slots[present] >= 0))
    return [styled("plans       ", "dim"), styled(f"{words or 'none'}; {placed} with a slot")]
