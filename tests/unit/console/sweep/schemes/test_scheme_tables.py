"""Schemes become cells of a sweep, rows of a table and lines of a figure."""

import math
from pathlib import Path

import numpy as np
import pytest

from console.sweep import design, ledger
from console.sweep.schemes import outcomes, picture, report
from console.sweep.table import Row
from fes.errors import FesError, ScenarioError
from tests.support.paths import CONFIGS
from world.config.scenario import load

PAIR = (CONFIGS / "pair.toml").read_text()
SCHEMES = """
[[scheme]]
name = "told"

[[scheme]]
name = "counts"
[scheme.set]
seeking = { index = "measured" }
"formation.linear_gain" = 2.0

[[scheme]]
name = "fixed"
[scheme.set]
seeking = { use = "fixed_separation", separation = 70.0 }

[[column]]
of = "metrics.travel.mean"
title = "travel [km]"
factor = 0.001
better = "smaller"
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "own.toml"
    path.write_text(PAIR + SCHEMES)
    return path


def table(planned: design.Design, *numbers: float | None) -> list[Row]:
    """One row per run, with these path lengths."""
    return [{"scheme": "", "seed": 0, "metrics.travel.mean": number, "error": None} for number in numbers]


def test_the_schemes_of_a_file_are_the_first_axis(file: Path) -> None:
    planned = design.plan(file, ["formation.rule=disk,two_nearest"], "0:2", ["run.duration=2"])
    assert planned.axes == ("scheme", "formation.rule")
    assert [cell.values for cell in planned.cells] == [
        (name, rule) for name in ("told", "counts", "fixed") for rule in ("disk", "two_nearest")
    ]
    gains = [cell.scenario.formation.linear_gain for cell in planned.cells]
    assert gains == [1.0, 1.0, 2.0, 2.0, 1.0, 1.0]
    assert {cell.scenario.run.duration for cell in planned.cells} == {2.0}


def test_a_scheme_may_be_chosen_by_an_axis_a_setting_or_an_override(file: Path) -> None:
    chosen = design.plan(file, ["scheme=fixed,told"], "0:1", [])
    assert [cell.values for cell in chosen.cells] == [("fixed",), ("told",)]
    one = design.plan(file, [], "0:1", ["scheme=counts", "formation.linear_gain=3"])
    assert (one.axes, len(one.cells)) == ((), 1)
    assert one.cells[0].scenario.formation.linear_gain == 3.0  # a setting comes before the scheme's
    assert load(file, {"scheme": "counts"}).formation.linear_gain == 2.0
    assert load(file) == load(file, {"scheme": "told"})


def test_runs_of_a_scheme_have_the_keys_of_the_same_scenario_in_a_file_of_its_own(file: Path, tmp_path: Path) -> None:
    alone = tmp_path / "alone.toml"
    alone.write_text(PAIR)
    assert design.plan(file, ["scheme=told"], "4", []).runs[0].key == design.plan(alone, [], "4", []).runs[0].key


def test_other_schemes_are_another_sweep(file: Path, tmp_path: Path) -> None:
    with ledger.opened(tmp_path / "out", design.plan(file, [], "0:1", [])):
        pass
    fewer = design.plan(file, ["scheme=told,fixed"], "0:1", [])
    with pytest.raises(FesError, match="other axes"), ledger.opened(tmp_path / "out", fewer):
        pass


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('[[scheme]]\nname = "a"\n[[scheme]]\nname = "a"\n', "expects each name once, got 'a' again"),
        ('[[scheme]]\nname = "a"\nst = {}\n', "unknown field 'scheme.0.st'; did you mean 'scheme.set'?"),
        ('[[scheme]]\nname = "a"\n[scheme.set]\n"formation.rul" = "disk"\n', "'formation.rul'"),
        ("[[column]]\nof = 'x'\n", "column.0.title: is required"),
    ],
)
def test_a_file_with_a_broken_scheme_is_rejected_in_one_line(text: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "broken.toml"
    path.write_text(PAIR + text)
    with pytest.raises(ScenarioError) as refused:
        design.plan(path, [], "0:1", [])
    assert message in str(refused.value)
    assert "\n" not in str(refused.value)


def test_an_unknown_scheme_and_a_file_without_schemes_are_named(file: Path) -> None:
    with pytest.raises(ScenarioError, match=r"there is no scheme 'fixd'; did you mean 'fixed'\?"):
        load(file, {"scheme": "fixd"})
    with pytest.raises(ScenarioError, match="there is no scheme 'fixed'; it has none"):
        load(CONFIGS / "pair.toml", {"scheme": "fixed"})


def test_the_means_have_students_interval_and_the_unit_of_their_column(file: Path) -> None:
    planned = design.plan(file, [], "0:3", [])
    rows = table(planned, 1000.0, 2000.0, 3000.0, 500.0, None, None, None, None, None)
    schemes = outcomes.of(planned, rows)
    assert schemes is not None
    told, counts, fixed = (row.means[0] for row in schemes.rows)
    # the deviation of 1, 2, 3 is 1; t of two degrees is 4.303
    assert told == pytest.approx(
        (2.0, 2.0 - 4.30265 / math.sqrt(3.0), 2.0 + 4.30265 / math.sqrt(3.0), 3, 3), abs=1e-5
    )
    assert (counts.mean, counts.reached, math.isnan(counts.low)) == (0.5, 1, True)
    assert (math.isnan(fixed.mean), fixed.reached, fixed.runs) == (True, 0, 3)
    assert [row.is_told for row in schemes.rows] == [True, False, False]
    assert report.markdown(schemes).splitlines() == [
        "| scheme | told the channel | travel [km] |",
        "| --- | --- | ---: |",
        "| told | yes | 2.00 ± 2.48 |",
        "| counts | no | 0.500 (1/3) |",
        "| fixed | no | – (0/3) |",
    ]


def test_a_column_without_a_number_is_an_error_that_names_the_nearest(file: Path) -> None:
    file.write_text(file.read_text().replace("travel.mean", "travel.men"))
    planned = design.plan(file, [], "0:1", [])
    with pytest.raises(ScenarioError, match=r"'metrics.travel.men'; did you mean 'metrics.travel.mean'\?"):
        outcomes.of(planned, table(planned, 1.0, 2.0, 3.0))


def test_a_sweep_without_schemes_has_no_such_table() -> None:
    planned = design.plan(CONFIGS / "pair.toml", ["formation.rule=disk,two_nearest"], "0:1", [])
    assert outcomes.of(planned, table(planned, 1.0, 2.0)) is None


def test_the_figure_marks_the_best_scheme_of_each_column(file: Path) -> None:
    planned = design.plan(file, [], "0:2", [])
    schemes = outcomes.of(planned, table(planned, 3000.0, 3000.0, 1000.0, 1200.0, 2000.0, 2000.0))
    assert schemes is not None
    [axes] = picture.schemes_figure(schemes).axes
    best, *lines = axes.get_lines()
    assert np.asarray(best.get_xdata()).tolist() == [1.1, 1.1]  # less travel is better
    marks = [line for line in lines if line.get_marker() == "o"]
    assert [float(np.asarray(mark.get_xdata())[0]) for mark in marks] == [3.0, 1.1, 2.0]
    assert [mark.get_fillstyle() for mark in marks] == ["none", "full", "full"]
    assert [label.get_text() for label in axes.get_yticklabels()] == ["told", "counts", "fixed"]
