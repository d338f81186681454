"""The printed summary of a run."""

import io
from typing import Any

import pytest
from rich.console import Console

from console.backends import inprocess
from console.dashboard import summary
from tests.support import loop


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
