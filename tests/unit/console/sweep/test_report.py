"""The comparison of a sweep as it is printed."""

import io

import pytest
from rich.console import Console

from console.sweep import comparison, design, report
from console.sweep.design import Design
from console.sweep.table import Row
from tests.support.paths import CONFIGS

METRIC, TIME = "metrics.travel.mean", "time_to.separation_1m"


@pytest.fixture
def planned() -> Design:
    return design.plan(CONFIGS / "pair.toml", ["formation.rule=disk,two_nearest"], "0:2", [])


def printed(planned: Design, travelled: dict[str, tuple[float, float]]) -> list[list[str]]:
    """The words of each line, for runs with these path lengths by rule and seed."""
    rows: list[Row] = [
        {"formation.rule": rule, "seed": seed, TIME: 9.0, METRIC: number, "digest": "f00", "error": None}
        for rule, numbers in travelled.items()
        for seed, number in enumerate(numbers)
    ]
    spreads, differences = list(comparison.spreads(planned, rows)), list(comparison.differences(planned, rows))
    screen = Console(width=100, file=io.StringIO())
    screen.print(report.render(planned, spreads, differences))
    assert isinstance(screen.file, io.StringIO)
    return [line.split() for line in screen.file.getvalue().split("\n")]


def test_numbers_of_metrics_are_printed_first_and_without_a_unit(planned: Design) -> None:
    lines = printed(planned, {"disk": (1.0, 3.0), "two_nearest": (2.0, 6.0)})
    first = lines.index([METRIC])
    assert lines[first + 1][-4:] == ["2/2", "2", "2", "3"]  # median, mean, largest
    assert lines[first + 2][-4:] == ["2/2", "4", "4", "6"]
    assert first < lines.index([TIME, "[s]"])


def test_paired_differences_of_metrics_are_printed(planned: Design) -> None:
    # By hand: 2 - 1 and 4 - 3 are 1 at both seeds, so the interval has no width.
    lines = printed(planned, {"disk": (1.0, 3.0), "two_nearest": (2.0, 4.0)})
    second = len(lines) - 1 - lines[::-1].index([METRIC])
    assert lines[second + 1][-5:] == ["2", "+1", "+1", "to", "+1"]


def test_the_team_index_is_printed_once_and_with_the_unit_of_its_table(planned: Design) -> None:
    names = ("team_index", "team_index_target", "team_index_99_at", "cutting_robots")
    rows: list[Row] = [
        {"formation.rule": rule, "seed": seed, TIME: 9.0, **dict.fromkeys(names, 0.5), "digest": "f00", "error": None}
        for rule in ("disk", "two_nearest")
        for seed in (0, 1)
    ]
    screen = Console(width=100, file=io.StringIO())
    screen.print(report.render(planned, list(comparison.spreads(planned, rows)), []))
    assert isinstance(screen.file, io.StringIO)
    headings = [line.strip() for line in screen.file.getvalue().split("\n") if line.strip().endswith("]")]
    assert headings == [
        "team_index [1]",
        "team_index_target [1]",
        "team_index_99_at [s]",
        "cutting_robots [robots]",
        f"{TIME} [s]",
    ]
