"""Columns of a Report for the panels of a page: one entry per robot, or per link, in SI units."""

import math
from typing import Any

import numpy as np

from console.measures import links, reception, team
from console.measures.links import FAIR_OUTAGE, POOR_OUTAGE
from fes.arrays.geometry import HEADING
from fes.arrays.types import Floats
from fes.protocol.report import Report

Columns = dict[str, Any]
"""Arrays or lists of equal length, by name."""

QUALITIES = (f"below {FAIR_OUTAGE:.0%}", f"below {POOR_OUTAGE:.0%}", "more, or unknown")
"""Classes of links by their outage, good ones first."""

INK, FADED, GREEN, ORANGE, RED, BLUE = "#222222", "#999999", "#009E73", "#E69F00", "#D55E00", "#0072B2"
"""Colors, of Okabe and Ito's palette but for the first two."""

LINK_COLORS = (GREEN, ORANGE, RED)
DASHES = ("solid", "dashed", "dotted")
"""Dashes of the classes, which tell them apart without color."""

ALIVE, CUTTING, AWAY = "alive", "alive, its loss would cut the links", "not alive"
"""States of a robot."""

ARROW = 14.0
"""Length of the arrow along a robot's heading [pixels]."""

POINTS = 64
"""Points of a curve of reception."""


def robots(report: Report) -> Columns:
    """The robots that are drawn, with position [m], heading [deg] and state.

    The marker of a robot that is not alive is a cross, without an arrow along its heading.
    """
    drawn = np.flatnonzero(team.on_map(report))
    alive, cutting = report.alive[drawn] == 1, np.isin(drawn, report.cutting)
    heading = np.where(np.isfinite(report.poses[drawn, HEADING]), report.poses[drawn, HEADING], 0.0)
    return {
        "robot": [str(robot) for robot in drawn.tolist()],
        "x": report.poses[drawn, 0],
        "y": report.poses[drawn, 1],
        "angle": heading,
        "tail": np.where(alive & np.isfinite(report.poses[drawn, HEADING]), report.poses[drawn, 0], math.nan),
        "heading": np.degrees(np.remainder(heading, math.tau)),
        "marker": np.where(alive, "circle", "x").tolist(),
        "color": np.where(~alive, RED, np.where(cutting, ORANGE, INK)).tolist(),
        "state": np.where(~alive, AWAY, np.where(cutting, CUTTING, ALIVE)).tolist(),
    }


def lines(report: Report) -> Columns:
    """The links between robots that are drawn: both ends [m], quality, and the columns of `table`."""
    on_map, known = team.on_map(report), links.known_ends(report)
    drawn = np.flatnonzero(known)
    drawn = drawn[on_map[report.a[drawn]] & on_map[report.b[drawn]]]
    kind = links.outage_class(links.loss(report)[drawn]).tolist()
    start, end = report.poses[report.a[drawn], :2], report.poses[report.b[drawn], :2]
    numbers = {name: np.asarray(values)[drawn].tolist() for name, values in table(report).items()}
    return {
        **numbers,
        **dict(zip(("x0", "y0", "x1", "y1"), np.column_stack([start, end]).T, strict=True)),
        "quality": [QUALITIES[index] for index in kind],
    }


def table(report: Report) -> Columns:
    """The numbers of each link, as in the terminal's dashboard: lengths [m], shares [1] and counts."""
    return {
        "link": [f"{a}–{b}" for a, b in zip(report.a.tolist(), report.b.tolist(), strict=True)],
        "separation": report.separation,
        "error": links.errors(report),
        "estimate_a": report.estimate_ab,
        "estimate_b": report.estimate_ba,
        "outage": links.loss(report),
        "decoded": links.counted(report),
        "learnt": report.learnt_reception,
        "true": 1.0 - report.outage,
        "sent": report.sent,
        "gap": report.longest_gap,
    }


def counted(report: Report) -> Columns:
    """Share of decoded beacons against separation [m] of each link."""
    known = reception.drawable(report) & np.isfinite(links.counted(report))
    numbers = table(report)
    return {name: np.asarray(numbers[name])[known] for name in ("link", "separation", "decoded", "learnt", "true")}


def curves(report: Report) -> tuple[Columns, Columns]:
    """Reception against separation [m], as learnt and true; without points where it is unknown."""
    known = reception.drawable(report)
    if not known.any():
        return _curve(np.zeros(0), np.zeros(0)), _curve(np.zeros(0), np.zeros(0))
    separation = np.linspace(*reception.separation_range(report.separation[known]), POINTS)
    learnt, true = reception.curves(report, separation)
    return _curve(separation, learnt), _curve(separation, true)


def _curve(separation: Floats, share: Floats) -> Columns:
    known = np.isfinite(share)
    return {"separation": separation[known], "reception": share[known]}
