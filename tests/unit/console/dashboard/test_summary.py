"""The printed summary of a run."""

import io
from pathlib import Path
from typing import Any

import pytest
from rich.console import Console

from console.backends import inprocess
from console.dashboard import summary
from tests.support import loop
from world.config import builtin
from world.config.scenario import Scenario, load


@pytest.fixture(scope="module")
def result() -> dict[str, Any]:
    return inprocess.run(loop.load("pair.toml", run__duration=1, metric=[{"use": "travel"}]), "pair")


def printed(result: dict[str, Any], verbose: bool = False) -> list[str]:
    screen = Console(width=80, file=io.StringIO())
    screen.print(summary.render(result, verbose))
    assert isinstance(screen.file, io.StringIO)
    return screen.file.getvalue().split("\n")


@pytest.mark.parametrize("verbose", [False, True])
def test_the_numbers_of_a_metric_of_the_scenario_are_printed(result: dict[str, Any], verbose: bool) -> None:
    mean, largest = (result["metrics"]["travel"][name] for name in ("mean", "largest"))
    [line] = [line for line in printed(result, verbose) if line.startswith("metrics")]
    assert line.split() == ["metrics", "travel:", "mean", f"{mean:.6g},", "largest", f"{largest:.6g}"]


def test_each_metric_has_a_row_and_a_number_that_it_lacks_is_marked(result: dict[str, Any]) -> None:
    lines = printed(result | {"metrics": {"first": {"ticks": 50.0, "nothing": None}, "second": {}}})
    start = next(number for number, line in enumerate(lines) if line.startswith("metrics"))
    rows = [line.split() for line in lines[start : start + 2]]
    assert rows == [["metrics", "first:", "ticks", "50,", "nothing", "–"], ["second:", "no", "numbers"]]


def test_a_metric_with_many_numbers_leaves_most_of_them_to_the_file(result: dict[str, Any]) -> None:
    many = {f"n{number}": float(number) for number in range(100)}
    [line] = [line for line in printed(result | {"metrics": {"many": many}}) if line.startswith("metrics")]
    assert len(line.rstrip()) <= 80
    assert int(line.split()[-2]) + line.count(" n") == 100  # "and 91 more"
    text = " ".join(" ".join(printed(result | {"metrics": {"many": many}}, verbose=True)).split())
    assert "n11 11, and 88 more in summary.json" in text
    assert "n12 12" not in text


def test_a_run_without_metrics_has_no_row_of_them(result: dict[str, Any]) -> None:
    assert not [line for line in printed(result | {"metrics": {}}) if line.startswith("metrics")]


def with_headline(result: dict[str, Any], verbose: bool = False) -> list[str]:
    """All lines after a run."""
    screen = Console(width=80, file=io.StringIO())
    screen.print(summary.last_line(result))
    assert isinstance(screen.file, io.StringIO)
    return [*printed(result, verbose)[:-1], "run directory: runs/x-1", *screen.file.getvalue().splitlines()]


@pytest.fixture(scope="module", params=builtin.names())
def shortened(request: pytest.FixtureRequest) -> tuple[Scenario, dict[str, Any]]:
    """A few ticks of a built-in scenario, and its summary."""
    path = builtin.resolve(Path(request.param))
    scenario = load(path, {"run.duration": 0.2, "run.clock": "lockstep"})
    return scenario, inprocess.run(scenario, request.param)


def test_the_summary_of_every_scenario_has_at_most_20_lines_with_the_headline_last(
    shortened: tuple[Scenario, dict[str, Any]],
) -> None:
    scenario, numbers = shortened
    lines = with_headline(numbers)
    assert len(lines) <= 20, "\n".join(lines)
    assert all(len(line.rstrip()) <= 80 for line in lines)
    assert lines[-1].startswith(f"{scenario.robots.number:,} robots, ")
    assert len(lines) == summary.below(scenario) + (numbers["links_lost_at"] is not None)


def test_a_summary_with_everything_has_at_most_20_lines(result: dict[str, Any]) -> None:
    live = {"missed": [10**6, 0], "late": [10**6, 0], "stopped": [10**6, 0], "missed_share": 0.5, "slipped_s": 1e4}
    verdict = {"of": "separation_error_max", "expected": "below 1.0", "seen": 2.0, "holds": False}
    everything = result | {
        "scenario": "x" * 100,
        "deadlines": live,
        "links_lost_at": 123.45,
        "expectations": [verdict] * 30,
        "metrics": {f"metric_{k}": {"value": 0.123456, "of_something_long": 7.0} for k in range(30)},
        "team_index": 0.5,
        "team_index_target": 0.7,
        "team_index_95_at": None,
        "team_index_99_at": None,
        "cutting_robots": None,
    }
    lines = with_headline(everything)
    assert len(lines) <= 20, "\n".join(lines)
    assert lines[-1] == "2 robots, team index 71.4% of its target; 30 of 30 expectations not met"
    assert any("30 expectations, 30 not met" in line for line in lines)


def test_many_expectations_and_metrics_share_the_lines(result: dict[str, Any]) -> None:
    verdict = {"of": "ticks", "expected": "below 1.0", "seen": 2.0, "holds": True}
    many = result | {
        "expectations": [*[verdict] * 9, verdict | {"holds": False}],
        "metrics": {f"metric_{k}": {"value": 0.5} for k in range(30)},
    }
    lines = with_headline(many)
    assert len(lines) == 20
    assert "does not hold" in next(line for line in lines if line.startswith("expected"))  # before those met
    assert [line.split()[-1] for line in lines if "10 expectations, 1 not met" in line] == ["met"]
    assert any("more with --verbose" in line for line in lines)
    assert lines[-1].endswith("; 1 of 10 expectations not met")


def test_verbose_shows_the_rest(result: dict[str, Any]) -> None:
    many = result | {"metrics": {f"metric_{k}": {"value": float(k)} for k in range(30)}}
    short, long = "\n".join(printed(many)), "\n".join(printed(many, verbose=True))
    for rest in ("at the end\n", "The mean estimate, in m", "metric_29: value 29", "fingerprint"):
        assert rest not in short
        assert rest in long


def test_an_error_that_reached_a_level_is_not_said_to_have_stayed_below_it(result: dict[str, Any]) -> None:
    times = dict.fromkeys(result["time_to"]) | {"estimate_1m": 2.06, "estimate_0_1m": 3.78, "separation_1m": 22.7}
    rows = {line[:16].strip(): line[18:].rstrip() for line in printed(result | {"time_to": times})}
    assert rows["estimate error"].endswith("; 1 m reached at 2.06 s, 0.1 m at 3.78 s")
    assert rows["separation error"].endswith("; 1 m reached at 22.70 s, 0.1 m not reached")
    assert rows["disagreement"].endswith("; 1 m not reached")


def test_a_share_of_the_team_index_that_held_to_the_end_has_its_time(result: dict[str, Any]) -> None:
    team = {"team_index": 0.6, "team_index_target": 0.625, "team_index_95_at": 74.1, "team_index_99_at": None}
    rows = {line[:16].strip(): line[18:].rstrip() for line in printed(result | team | {"cutting_robots": 0})}
    assert rows["team index"] == "0.6000 of 0.6250 (96.0%); 95% since 74.10 s, 99% not held"
    assert rows["cutting robots"] == "none"


def test_where_a_robot_is_absent_the_connectivity_is_that_of_the_linked_ones(
    result: dict[str, Any],
) -> None:
    path = [[0, 1, 60.0, 60.0, 60.0], [1, 3, 60.0, 60.0, 60.0]]
    absent = result | {"robots": 4, "edges": path, "algebraic_connectivity": 0.0}
    assert "λ₂ 1.0000 of 3 linked" in printed(absent)[0]
    assert printed(absent | {"robots": 3})[0].rstrip().endswith("λ₂ 0.0000")
