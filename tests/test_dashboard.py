"""The dashboard, read back from the frames it draws, as a person would."""

import io
import math
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rich.cells import cell_len
from rich.console import Console
from rich.segment import Segment

from agents import crew
from console import panels
from console.canvas import Canvas
from console.dashboard import CAPACITY, History, render
from fes import outage
from fes.arrays import Floats, Ints
from fes.report import Report
from fes.sensing import silence
from world import optimum, scenario, simulation

SIZES = [(80, 24), (100, 30), (160, 50), (300, 80), (71, 24), (60, 40), (40, 12)]
TINY = [(160, 8), (200, 3), (80, 1), (20, 30), (20, 5), (3, 2), (1, 1)]
PAPER = Path(__file__).parents[1] / "configs" / "paper.toml"
OPTIMUM = 68.11  # m


Pairs = Sequence[tuple[float, float]] | Floats


def a_report(positions: Pairs, links: Sequence[tuple[int, int]] | Ints = (), **fields: object) -> Report:
    """A Report of robots at `positions` [n, 2] [m], looking east, with links as pairs of ids."""
    at = np.asarray(positions, dtype=np.float64).reshape(-1, 2)
    poses = np.column_stack([at, np.zeros(len(at))])
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
        decoded_ratio=np.exp(-3e-7 * separation**3),
        beacons_sent=1000,
        beacons_decoded=900,
        disagreement=2.5,
        estimate_error_max=math.nan,
        separation_error_max=float(np.abs(separation - OPTIMUM).max(initial=0.0)),
        disk_connected=True,
    )
    return replace(report, **fields)  # type: ignore[arg-type]


def a_swarm(n: int) -> Report:
    """`n` robots on a square grid, each linked to the next ten."""
    side = math.ceil(math.sqrt(n))
    positions = [(50.0 * (k % side), 50.0 * (k // side)) for k in range(n)]
    return a_report(positions, [(k, other) for k in range(n) for other in range(k + 1, min(n, k + 11))])


def a_history(*reports: Report) -> History:
    history = History()
    for report in reports:
        history.add(report)
    return history


def pieces(history: History, width: int, height: int) -> list[list[Segment]]:
    console = Console(width=width, height=height, file=io.StringIO(), force_terminal=True)
    return console.render_lines(render(history, width, height), console.options, pad=False)


def frame(history: History, width: int = 100, height: int = 30) -> list[str]:
    """What is printed, line by line."""
    console = Console(width=width, height=height, file=io.StringIO())
    console.print(render(history, width, height))
    assert isinstance(console.file, io.StringIO)
    return console.file.getvalue().split("\n")[:-1]


def team_map(report: Report, width: int = 100, height: int = 30) -> list[str]:
    """The lines of the map without its title and scale."""
    lines = frame(a_history(report), width, height)
    side = lines[2].index("Convergence")
    return [line[:side] for line in lines[3:-1]]


def find(lines: list[str], mark: str) -> tuple[int, int]:
    """Column and row of the one cell that shows `mark`."""
    found = [(line.index(mark), row) for row, line in enumerate(lines) if mark in line]
    assert len(found) == 1, "\n".join(lines)
    return found[0]


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


@pytest.fixture(scope="module")
def played() -> list[Report]:
    """Reports of the first 3 s of the paper's ten robots."""
    setup = scenario.load(PAPER, {})
    world = simulation.create(setup)
    team = crew.assemble(scenario.agent_config(setup), world.ids)
    state, robots, said = simulation.start(world), crew.start(team), silence()
    best = optimum.optimal_separation(setup.objective, setup.channel)
    reports = []
    for tick in range(151):
        robots, said, twists = crew.step(team, robots, simulation.observe(state), said)
        if tick % 10 == 0:
            edges, at = said.links, said.links.mutual
            a, b, ab, ba = (
                edges.ids[edges.rows[at]],
                edges.peers[at],
                said.estimates[at],
                said.estimates[edges.reverse[at]],
            )
            pairs = np.column_stack([a, b])
            report = a_report(state.poses[:, :2], pairs, poses=state.poses, estimate_ab=ab, estimate_ba=ba)
            lost = 1.0 - outage.reception_probability(report.separation, setup.channel)
            wrong = float(np.abs(np.concatenate([ab, ba]) - best).max(initial=0.0))
            summed = float(np.abs(ab - ba).sum())
            reports.append(replace(report, tick=tick, outage=lost, disagreement=summed, estimate_error_max=wrong))
        state = simulation.step(world, state, twists)
    return reports


@pytest.mark.parametrize(("width", "height"), SIZES + TINY)
@pytest.mark.parametrize("robots", [None, 0, 1, 2, 10, 100, 1000])
def test_a_frame_has_exactly_the_size_asked_for(robots: int | None, width: int, height: int) -> None:
    history = History() if robots is None else a_history(a_swarm(robots))
    lines = frame(history, width, height)
    assert [cell_len(line) for line in lines] == [width] * height


def test_before_the_first_report_it_waits() -> None:
    assert "waiting for the world" in "".join(frame(History(), 80, 24))


def test_a_robot_to_the_east_is_drawn_to_the_right_and_one_to_the_north_above() -> None:
    poses = np.array([[0.0, 0.0, 0.0], [80.0, 0.0, math.pi / 2], [0.0, 80.0, math.pi]])
    lines = team_map(a_report(poses[:, :2], poses=poses))
    (here, level), (east, level_east), (north, level_north) = (find(lines, arrow) for arrow in "→↑←")
    assert east > here
    assert level_east == level
    assert north == here
    assert level_north < level


@pytest.mark.parametrize(("width", "height"), SIZES[:3])
def test_a_square_is_drawn_square_within_a_dot(width: int, height: int) -> None:
    corners = [(0.0, 0.0), (60.0, 0.0), (60.0, 60.0), (0.0, 60.0)]
    drawn = dots(team_map(a_report(corners, [(0, 1), (1, 2), (2, 3), (0, 3)]), width, height))
    across, up = np.ptp(drawn, axis=0)
    assert across > 20
    assert abs(across - up) <= 1


def test_the_scale_tells_the_metres_between_two_robots() -> None:
    poses = np.array([[0.0, 0.0, 0.0], [140.0, 0.0, math.pi]])
    report = a_report(poses[:, :2], poses=poses)
    (left, _), (right, _) = (find(team_map(report), arrow) for arrow in "→←")
    bar, metres = re.findall(r"(├─*┤) (\d+) m", frame(a_history(report))[-1])[0]
    # Both are whole cells: half a cell of the bar's fifteen or so, and one of the forty between the robots
    assert (right - left) * int(metres) / len(bar) == pytest.approx(140.0, rel=0.06)


def test_every_robot_of_the_paper_is_named_on_the_map(played: list[Report]) -> None:
    for report in played:
        names = re.findall(r"\d+", " ".join(team_map(report)))
        assert sorted(map(int, names)) == list(range(10))


def test_links_of_more_outage_have_fewer_dots() -> None:
    good, fair, poor, unknown = (
        len(dots(team_map(a_report([(0.0, 0.0), (90.0, 0.0)], [(0, 1)], outage=np.array([lost])))))
        for lost in (0.1, 0.2, 0.5, math.nan)
    )
    assert good > 1.5 * fair
    assert fair > 1.5 * poor > 0
    assert unknown == poor


def test_numbers_that_do_not_exist_are_drawn_as_such() -> None:
    nothing = np.full(1, math.nan)
    poses = np.array([[0.0, 0.0, math.nan], [math.nan, 1.0, 0.0], [math.inf, 0.0, 0.0], [5.0, 5.0, 0.0]])
    report = a_report([(0.0, 0.0)] * 4, [(0, 1)], poses=poses, separation=nothing, outage=nothing)
    report = replace(report, disagreement=math.inf, ticks_per_s=math.nan, optimal_separation=math.nan, dt=math.nan)
    for width, height in SIZES + TINY:
        assert len(frame(a_history(report, report), width, height)) == height
    row = next(line for line in frame(a_history(report)) if "0–1" in line)
    assert row.split("0–1")[1].split()[0] == "–"


def test_a_link_to_a_robot_that_is_not_there_is_left_out_of_map_and_graph() -> None:
    report = replace(a_report([(0.0, 0.0), (9.0, 0.0)], [(0, 1)]), b=np.array([7]))
    assert "2 components (1, 1)" in "".join(frame(a_history(report)))


def test_no_links_are_said_to_be_none() -> None:
    assert "no links" in "".join(frame(a_history(a_report([(0.0, 0.0), (50.0, 0.0)]))))


def test_links_stand_in_the_order_of_their_separation_error() -> None:
    report = a_report([(0.0, 0.0), (60.0, 0.0), (160.0, 0.0), (230.0, 0.0)], [(0, 1), (1, 2), (2, 3)])
    shown = re.findall(r"\d–\d", "".join(frame(a_history(report))[3:]))
    assert shown == ["1–2", "0–1", "2–3"]  # 100, 60 and 70 m, where 68.11 m is wanted


@pytest.mark.parametrize(("width", "height"), SIZES[:3])
def test_links_that_do_not_fit_are_counted(width: int, height: int) -> None:
    report = a_swarm(100)
    text = "\n".join(frame(a_history(report), width, height)[3:])
    more = int(re.search(r"… and ([\d,]+) more", text)[1].replace(",", ""))  # type: ignore[index]
    assert len(re.findall(r"\d–\d", text)) + more == len(report.a)


@pytest.mark.parametrize("rows", [1, 2, 5])
def test_a_falling_series_has_falling_bars(rows: int) -> None:
    values = 50.0 * np.exp(-np.arange(40) / 4.0)
    heights = bar_heights(panels.bar_rows(values, *panels.log_range(values), rows))
    assert heights == sorted(heights, reverse=True)
    assert heights[0] == 8 * rows
    # A log scale makes an exponential a straight line
    assert np.diff(heights) == pytest.approx((heights[-1] - heights[0]) / 39, abs=1.0)


def test_a_falling_disagreement_has_falling_bars_in_the_frame() -> None:
    start = a_report([(0.0, 0.0), (60.0, 0.0)], [(0, 1)])
    history = a_history(*(replace(start, tick=k, disagreement=10.0 * 0.9**k) for k in range(100)))
    row = next(line for line in frame(history, 60, 20) if line.startswith("disagreement"))
    heights = bar_heights([row[len("separation error ") : -len("   295 µm")]])
    assert heights == sorted(heights, reverse=True)
    assert heights[0] == 8
    assert 1 <= heights[-1] <= 3  # 0.3 mm, on a scale that begins at 0.1 mm
    assert row.endswith(" 295 µm")  # 10 m * 0.9^99


def test_a_dead_robot_is_shown_dead() -> None:
    report = replace(a_swarm(10), alive=np.array([1, 1, 1, 0, 1, 1, 1, 1, 1, 1], dtype=np.uint8))
    history = a_history(report)
    text = "\n".join(frame(history))
    assert "9/10" in text
    assert re.search(r"not alive +3\b", text)
    red = [piece.text for line in pieces(history, 100, 30) for piece in line if "red" in str(piece.style)]
    assert any("×" in text for text in red)
    assert "9/10" in red
    assert not any("→" in text for text in red)


def test_the_algebraic_connectivity_is_that_of_known_graphs() -> None:
    row = [(0.0, 0.0), (50.0, 0.0), (100.0, 0.0)]
    assert "λ₂ 1 " in "".join(frame(a_history(a_report(row, [(0, 1), (1, 2)]))))  # a path of three
    assert "λ₂ 3 " in "".join(frame(a_history(a_report(row, [(0, 1), (1, 2), (0, 2)]))))  # a triangle
    assert "2 components (2, 1)" in "".join(frame(a_history(a_report(row, [(0, 1)]))))


def test_a_history_stays_small_and_forgets_no_peak() -> None:
    start = a_report([(0.0, 0.0)], disagreement=0.5)
    history = a_history(*(replace(start, tick=k, disagreement=9.0 if k == 777 else 0.5) for k in range(5000)))
    held = history.series(100_000)[0]
    assert 1 + np.count_nonzero(np.diff(held)) <= 3
    assert np.isclose(held, 9.0).mean() == pytest.approx(1.0 / 625, rel=0.05)  # one bin of eight ticks in 5000
    assert 5000 // history.stride <= CAPACITY
    assert history.series(7)[0].tolist() == [0.5, 9.0, 0.5, 0.5, 0.5, 0.5, 0.5]


def test_reports_far_apart_leave_no_holes() -> None:
    start = a_report([(0.0, 0.0)])
    history = a_history(*(replace(start, tick=tick) for tick in (1_000_000, 1_000_900, 1_500_000)))
    assert history.series(50)[0].tolist() == [2.5] * 50
    assert history.ticks[0] == pytest.approx(1_000_000, abs=history.stride)


def test_an_earlier_tick_begins_a_new_history() -> None:
    start = a_report([(0.0, 0.0)])
    history = a_history(replace(start, tick=5000, disagreement=9.0), replace(start, tick=0, disagreement=1.0))
    assert history.series(3)[0].tolist() == [1.0, 1.0, 1.0]
    assert history.ticks == (0, 0)


def test_a_name_cannot_move_the_cursor() -> None:
    lines = frame(a_history(replace(a_swarm(2), scenario="a\x1b[2J\nb")), 80, 24)
    assert len(lines) == 24
    assert lines[0].startswith("a?[2J?b")


@pytest.mark.parametrize("end", [(70.5, 3.5), (70.2, 31.0), (9.5, 38.5), (1.5, 1.5)])
def test_a_solid_line_has_no_gap(end: tuple[float, float]) -> None:
    canvas = Canvas(40, 10, ("", "red"))
    canvas.lines(np.array([[1.5, 1.5]]), np.array([end]), np.array([1]), np.array([[1, 1]]))
    drawn = dots(["".join(segment.text for segment in line) for line in canvas.render()])
    longest = int(np.ptp(drawn, axis=0).max())
    assert len(drawn) == longest + 1
    assert longest == pytest.approx(max(end) - 1.5, abs=1.0)  # half a dot at each end
    near = np.abs(drawn[:, None] - drawn[None]).max(axis=2) <= 1  # each touches the next
    assert near.sum() == len(drawn) + 2 * longest


def test_drawing_outside_the_canvas_leaves_it_as_it_is() -> None:
    canvas = Canvas(4, 2, ("", "red"))
    away = np.array([[-9.0, -9.0], [20.0, 3.0]])
    canvas.lines(away, away + 5.0, np.array([1, 1]), np.array([[1, 1], [1, 1]]))
    canvas.write(-1, 0, "x", 1)
    assert "".join(segment.text for line in canvas.render() for segment in line) == " " * 8
