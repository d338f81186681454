"""The settled numbers of the team index, and those that docs/explanation/team.md prints."""

import re

import numpy as np
import pytest

from console.analysis import claims, convergence_study, team_claims
from fes.shapes import choice
from tests.support import configuration_runs, ends
from tests.support.loop import load
from tests.support.paths import DOCS

PAGE = (DOCS / "explanation" / "team.md").read_text(encoding="utf-8")
ROWS = [[cell.strip() for cell in line.strip("|").split("|")] for line in PAGE.splitlines() if line.startswith("| ")]
"""The rows of all tables of the page."""

DRAWN = {
    "line at r\\*": "line at r*",
    "line at its best length, 58.7 m": "line at 58.7 m",
    "ring at r\\*": "ring at r*",
    "ring at its best length, 65.4 m": "ring at 65.4 m",
    "ladder at r\\*": "ladder 2 x 5 at r*",
    "patch at r\\*": "patch at r*",
    "patch at r_β": "patch at r_beta",
}
"""Row of the table of ends -> its name in `tests.support.ends`."""


def digits(cell: str) -> float:
    """Half a unit of the last digit of a number."""
    return 0.5 * 10.0 ** -len(cell.partition(".")[2])


@pytest.mark.parametrize("n", ends.SIZES)
def test_the_page_prints_the_patch_of_each_size(n: int) -> None:
    (row,) = (row for row in ROWS if row[0] == str(n))
    for cell, value in zip(row, ends.patch(n), strict=True):
        assert float(cell) == pytest.approx(value, abs=digits(cell))


def test_the_page_prints_the_index_of_each_shape_of_ten_robots() -> None:
    shapes = dict(ends.shapes())
    assert set(DRAWN.values()) == set(shapes)
    for title, name in DRAWN.items():
        (row,) = (row[1:] for row in ROWS if row[0] == title)
        for cell, value in zip(row, shapes[name], strict=True):
            assert float(cell) == pytest.approx(value, abs=digits(cell))


def test_the_best_lengths_of_line_and_ring_are_the_best() -> None:
    for name, length in (("line", ends.LINE), ("ring", ends.RING)):
        slots = choice.shape(name, 10, 1).slots
        best, *others = (team_claims.index_of(r * slots).value for r in (length, length - 0.2, length + 0.2))
        assert best > max(others), name


def test_the_claims_are_the_settled_numbers() -> None:
    numbers = claims.CLAIMS["team-index"]()
    settled = {
        "J at r*, and F of two robots": (0.84385, 5e-6),
        "beta of ten robots": (0.51170, 5e-6),
        "r_beta of ten robots [m]": (71.26, 0.005),
        "F of ten robots at r*": (0.6768, 5e-5),
        "F of ten robots at r_beta": (0.6894, 5e-5),
        "r_beta / r*, n = 3": (1.0477, 5e-5),
        "r_beta / r*, n = 10": (1.0462, 5e-5),
        "r_beta / r*, n = 100": (0.9996, 5e-5),
        "r_beta / r*, n = 10, r_min 100": (1.0975, 1e-4),  # 1.09745
        "F at r*, n = 10, r_min 100": (0.0850, 5e-5),
        "F at r_beta, n = 10, r_min 100": (0.1018, 5e-5),
    }
    assert set(settled) == set(numbers) - {"r* [m]"}
    for name, (value, tolerance) in settled.items():
        assert numbers[name] == pytest.approx(value, abs=tolerance), name


def test_no_robot_near_its_place_improves_the_patch_of_ten_by_a_percent() -> None:
    slots = choice.shape("lattice", 10, 1).slots
    places = team_claims.spacings("lattice", 10)[1] * slots
    before, draws = team_claims.index_of(places).value, np.random.default_rng(2)
    moved = [
        team_claims.index_of(places + draws.normal(0.0, size, places.shape)).value
        for size in (1.0, 4.0)
        for _ in range(100)
    ]
    assert max(moved) < 1.01 * before


def test_the_page_prints_the_amplitudes_that_a_breathing_shape_costs() -> None:
    slots, (_, best) = choice.shape("lattice", 10, 1).slots, team_claims.spacings("lattice", 10)
    still, phases = team_claims.index_of(best * slots).value, 2.0 * np.pi * np.arange(40) / 40.0
    printed = re.search(r"An amplitude of 3 m costs ([\d.]+) % of F, and 5 m cost ([\d.]+) %", PAGE)
    assert printed is not None
    for amplitude, percent in zip((3.0, 5.0), printed.groups(), strict=True):
        mean = np.mean([team_claims.index_of((best + amplitude * np.sin(phase)) * slots).value for phase in phases])
        assert 100.0 * (1.0 - mean / still) == pytest.approx(float(percent), abs=digits(percent))


@pytest.mark.slow
def test_a_run_of_each_law_has_an_end_in_the_range_that_the_page_prints() -> None:
    for title, scenario in ends.RULES.items():
        (cells,) = (row[1:] for row in ROWS if row[0] == f"{title}, 10 seeds")
        low, high = map(float, cells[0].partition("[")[2].rstrip("]").split(", "))
        (result,) = ends.runs(scenario, [1])
        assert low - 5e-4 <= result.team_index <= high + 5e-4
        assert (result.links, result.cutting) == (int(cells[3]), int(cells[4]))


@pytest.mark.parametrize(
    ("settings", "bound"),
    [({}, 1.70), ({"objective__minimum_separation": 100.0}, 8.62), ({"channel__reference_snr": 5e6}, 1.75)],
)
def test_the_lower_bound_of_the_time_to_find_the_best_length(settings: dict[str, float], bound: float) -> None:
    measured = configuration_runs.scenario(
        "paper", 10, 1, 60.0, "measured", seeking__dither_amplitude=5.0, **settings
    )
    weight = choice.shape("lattice", 10, 1).quality_weight(1, 1.0)
    assert convergence_study.time_to_one_meter(measured, 38, weight) == pytest.approx(bound, abs=0.005)


def test_the_lower_bound_of_a_link_of_its_own() -> None:
    measured = load("measured.toml")
    assert convergence_study.time_to_one_meter(measured, 1) == pytest.approx(89.6, abs=0.05)
    assert convergence_study.time_to_one_meter(measured, 18) == pytest.approx(4.98, abs=0.005)
