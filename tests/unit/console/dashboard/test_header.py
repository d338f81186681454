"""The source of the index in the first line of the dashboard."""

import pytest

from console.connect import index_source
from tests.support import loop
from tests.support.frames import SIZES, a_history, a_report, frame, measured

PAIR = [(0.0, 0.0), (60.0, 0.0)]


@pytest.mark.parametrize(
    ("name", "expected"),
    [("paper.toml", "oracle"), ("measured.toml", "measured"), ("swap.toml", "own law"), ("team.toml", "measured")],
)
def test_the_source_is_that_of_the_scenario(name: str, expected: str) -> None:
    assert index_source.of(loop.load(name)) == expected


@pytest.mark.parametrize(("width", "height"), SIZES)
@pytest.mark.parametrize("name", ["oracle", "measured", "sampled"])
def test_the_first_line_names_the_source_if_there_is_room(name: str, width: int, height: int) -> None:
    history = a_history(a_report(PAIR, [(0, 1)]))
    history.source = name
    assert (f"test  index {name}  " in frame(history, width, height)[0]) == (width > 40)


def test_a_viewer_that_does_not_know_the_scenario_sees_that_robots_measure() -> None:
    report = a_report(PAIR, [(0, 1)])
    assert "index measured" in frame(a_history(measured(report, -2.0, 3.0)))[0]
    assert "index" not in frame(a_history(report))[0]


def test_a_long_name_leaves_no_room_for_the_source() -> None:
    history = a_history(a_report(PAIR, [(0, 1)], scenario="x" * 60))
    history.source = "oracle"
    assert "index" not in frame(history, 100, 30)[0]
