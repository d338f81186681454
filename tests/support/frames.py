"""Reports to draw, and readers of the frames that the dashboard draws."""

import io
import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from rich.console import Console
from rich.segment import Segment

from agents.control import crew
from agents.runtime.reception import Receiver
from console.dashboard.frame import render
from console.dashboard.history import ReportHistory
from fes.arrays.types import Floats, Ints
from fes.model import outage
from fes.model.sensing import no_beacons
from fes.protocol.report import Report
from tests.support import loop
from tests.support.paths import CONFIGS
from world.config import scenario
from world.metrics import optimum
from world.simulation import truth

SIZES = [(80, 24), (100, 30), (160, 50), (300, 80), (71, 24), (60, 40), (40, 12)]
TINY = [(160, 8), (200, 3), (80, 1), (20, 30), (20, 5), (3, 2), (1, 1)]
PAPER = CONFIGS / "paper.toml"
OPTIMUM = 68.11  # m


Pairs = Sequence[tuple[float, float]] | Floats


def a_report(positions: Pairs, links: Sequence[tuple[int, int]] | Ints = (), **fields: object) -> Report:
    """A Report of robots at `positions` [n, 2] [m], looking east, with links as pairs of ids."""
    places = np.asarray(positions, dtype=np.float64).reshape(-1, 2)
    poses = np.column_stack([places, np.zeros(len(places))])
    a, b = np.asarray(links, dtype=np.int64).reshape(-1, 2).T
    separation = np.hypot(*(poses[a, :2] - poses[b, :2]).T)
    report = Report(
        scenario="test",
        tick=10,
        ticks=100,
        dt=0.02,
        optimal_separation=OPTIMUM,
        elapsed=0.1,
        ticks_per_s=100.0,
        alive=np.ones(len(poses), dtype=np.uint8),
        poses=poses,
        a=a,
        b=b,
        separation=separation,
        estimate_ab=separation + 1.0,
        estimate_ba=np.full(len(a), math.nan),
        outage=1.0 - np.exp(-3e-7 * separation**3),
        sent=np.full(len(a), 1000.0),
        decoded=np.round(1000.0 * np.exp(-3e-7 * separation**3)),
        longest_gap=np.full(len(a), 4.0),
        learnt_reception=np.full(len(a), math.nan),
        learnt_level=np.full(len(a), math.nan),
        learnt_exponent=np.full(len(a), math.nan),
        true_level=math.log(3e-7 * 75.0**3),
        true_exponent=3.0,
        mean_estimate_error=1.5,
        changed_at=0.0,
        tracking_time=math.nan,
        beacons_sent=1000,
        beacons_decoded=900,
        disagreement=2.5,
        estimate_error_max=math.nan,
        separation_error_max=float(np.abs(separation - OPTIMUM).max(initial=0.0)),
        missed=np.zeros(0, dtype=np.int64),
        late=np.zeros(0, dtype=np.int64),
        disk_connected=True,
    )
    return replace(report, **fields)  # type: ignore[arg-type]


def a_swarm(n: int) -> Report:
    """`n` robots on a square grid, each linked to the next ten."""
    side = math.ceil(math.sqrt(n))
    positions = [(50.0 * (k % side), 50.0 * (k // side)) for k in range(n)]
    return a_report(positions, [(k, neighbor) for k in range(n) for neighbor in range(k + 1, min(n, k + 11))])


def measured(report: Report, level: float, exponent: float) -> Report:
    """The report with the learnt law p = exp(-exp(level) (r / 75 m)^exponent) on all links."""
    links = np.ones(len(report.a))
    learnt = np.exp(-math.exp(level) * (report.separation / 75.0) ** exponent)
    return replace(report, learnt_reception=learnt, learnt_level=level * links, learnt_exponent=exponent * links)


def a_history(*reports: Report) -> ReportHistory:
    history = ReportHistory()
    for report in reports:
        history.add(report)
    return history


def pieces(history: ReportHistory, width: int, height: int) -> list[list[Segment]]:
    console = Console(width=width, height=height, file=io.StringIO(), force_terminal=True)
    return console.render_lines(render(history, width, height), console.options, pad=False)


def frame(history: ReportHistory, width: int = 100, height: int = 30) -> list[str]:
    """Lines of a printed object."""
    console = Console(width=width, height=height, file=io.StringIO())
    console.print(render(history, width, height))
    assert isinstance(console.file, io.StringIO)
    return console.file.getvalue().split("\n")[:-1]


def team_map(report: Report, width: int = 100, height: int = 30) -> list[str]:
    """The lines of the map without its title and scale."""
    lines = frame(a_history(report), width, height)
    side = lines[2].index("Convergence")
    last = next(row for row, line in enumerate(lines) if line.startswith("├"))
    return [line[:side] for line in lines[3:last]]


def find(lines: list[str], mark: str) -> tuple[int, int]:
    """Column and row of the one cell that shows `mark`."""
    cells = [(line.index(mark), row) for row, line in enumerate(lines) if mark in line]
    assert len(cells) == 1, "\n".join(lines)
    return cells[0]


def dots(lines: list[str]) -> Floats:
    """(x, y) of the dots in the lines, decoded from Unicode's numbering of braille dots [k, 2]."""
    place = [(0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (1, 2), (0, 3), (1, 3)]
    return np.array(
        [
            (2 * column + x, 4 * row + y)
            for row, line in enumerate(lines)
            for column, character in enumerate(line)
            for bit, (x, y) in enumerate(place)
            if 0x2800 <= ord(character) <= 0x28FF and (ord(character) - 0x2800) >> bit & 1
        ]
    )


def bar_heights(rows: list[str]) -> list[int]:
    return [sum(" ▁▂▃▄▅▆▇█".index(row[column]) for row in rows) for column in range(len(rows[0]))]


def play() -> list[Report]:
    """Reports of the first 3 s of the paper's ten robots."""
    setup = scenario.load(PAPER, {})
    world = truth.create(setup)
    team = crew.create(scenario.agent_config(setup), world.ids)
    state, robots, beacons, receiver = truth.start(world), crew.start(team), no_beacons(), Receiver()
    best = optimum.optimal_separation(setup.objective, setup.channel)
    reports = []
    for tick in range(151):
        robots, beacons, twists, _ = loop.tick(team, robots, receiver, truth.observe(state), beacons)
        if tick % 10 == 0:
            edges, mutual = beacons.links, beacons.links.mutual
            a, b, ab, ba = (
                edges.ids[edges.rows[mutual]],
                edges.peers[mutual],
                beacons.estimates[mutual],
                beacons.estimates[edges.reverse[mutual]],
            )
            pairs = np.column_stack([a, b])
            report = a_report(state.poses[:, :2], pairs, poses=state.poses, estimate_ab=ab, estimate_ba=ba)
            lost = 1.0 - outage.reception_probability(report.separation, setup.channel)
            wrong = float(np.abs(np.concatenate([ab, ba]) - best).max(initial=0.0))
            summed = float(np.abs(ab - ba).sum())
            reports.append(replace(report, tick=tick, outage=lost, disagreement=summed, estimate_error_max=wrong))
        state = truth.step(world, state, twists)
    return reports
