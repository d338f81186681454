"""The numbers of docs/explanation/paper.md, as `fes claims` computes them."""

import importlib
import math
import re

import numpy as np
import pytest

from agents.laws import oracle
from console.analysis import claims
from fes.arrays.types import Floats
from tests.support.loop import load
from tests.support.paths import DOCS, ROOT

PAPER = (DOCS / "explanation" / "paper.md").read_text(encoding="utf-8")
TEAM = (DOCS / "explanation" / "team.md").read_text(encoding="utf-8")


def test_the_printed_law_freezes_a_disagreement_at_one_third() -> None:
    numbers = claims.printed_law()
    # The gradient, at its time constant of half a day, moves the estimates by some millimeters in 10 s.
    assert numbers["disagreement after 10 s [m]"] == pytest.approx(20.0 / 3.0, abs=0.002)
    assert numbers["change of beta_l r_hat + xi"] < 0.01


def test_the_corrected_law_agrees_with_the_eigenvalues_by_hand() -> None:
    numbers = claims.corrected_law()
    assert numbers["disagreement after 4 s [m]"] < 20.0 * 2.718281828 ** (-6.0 * 4.0) * 100.0
    # lambda^2 + 12 lambda + 64 = 0, and lambda^2 + 12 lambda = 0 as printed
    assert numbers["eigenvalues, real part [1/s]"] == pytest.approx(-6.0)
    assert numbers["eigenvalues, imaginary part [rad/s]"] == pytest.approx(28.0**0.5)
    assert numbers["printed law, largest eigenvalue [1/s]"] == pytest.approx(0.0, abs=1e-9)
    assert numbers["printed law, smallest eigenvalue [1/s]"] == pytest.approx(-12.0)


def test_the_printed_gains_take_half_a_day() -> None:
    # From J'' = -1.12460e-3 and -4.59919e-4 of the settled figures: 50 / |J''|.
    assert list(claims.time_constant().values())[-2:] == pytest.approx(
        [50.0 / 1.12460e-3, 50.0 / 4.59919e-4], rel=1e-4
    )


def test_only_exponents_four_and_three_give_the_optima_of_figure_three() -> None:
    numbers = claims.two_exponents()
    right = {name for name, best in numbers.items() if round(best) in (68, 105)}
    assert {name for name in right if "r_min 100" in name} == {"r* with shape exponent 4, r_min 100 [m]"}
    assert "r* with shape exponent 4, r_min 50 [m]" in right


def test_weights_leave_nothing_for_the_robot_itself_and_are_not_symmetric() -> None:
    numbers = claims.weights()
    assert numbers["a_ii by (1), three neighbors"] == 0.0
    assert numbers["sum of weights, one neighbor"] == 0.5
    assert numbers["a_ij of a robot with three neighbors"] != numbers["a_ji of its peer with two"]


class OtherLastBit(oracle.FormulaIndex):
    """The index with another last bit."""

    def __call__(self, separation: Floats) -> Floats:
        return np.nextafter(super().__call__(separation), 0.0)

    def parabola(self, separation: Floats) -> tuple[Floats, Floats, Floats]:
        value, slope, bend = super().parabola(separation)
        return np.nextafter(value, 0.0), slope, bend


@pytest.fixture(scope="module", params=[oracle.FormulaIndex, OtherLastBit])
def disk(request: pytest.FixtureRequest) -> dict[str, float]:
    """The end of the disk graph, also with an index that differs in its last bit: the end does not hang on one."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(oracle, "FormulaIndex", request.param)
        return claims.disk_graph()


def test_the_disk_graph_is_frustrated(disk: dict[str, float]) -> None:
    assert disk["links"] == 45.0
    assert disk["shortest link, most over seeds [m]"] < 40.0
    assert disk["longest link, least over seeds [m]"] > 95.0


def test_two_nearest_starts_in_two_parts() -> None:
    parts = claims.two_parts()
    assert parts["two_nearest: links always connected"] == 0.0
    assert parts["relative_neighborhood: links always connected"] == 1.0
    assert parts["relative_neighborhood: largest error of a link at the end [m]"] <= 0.0011


def test_a_gain_alone_moves_the_printed_law_and_makes_the_slow_mode_two_thirds_of_a_second() -> None:
    numbers, times = claims.printed_law(), claims.time_constant()
    # lambda^2 + 12 lambda + 4 g = 0 with g = 1/(1 + (25/100)^2): the slow root decays by e^-3.2 in 10 s, from 20/3 m
    slow = 6.0 - math.sqrt(36.0 - 4.0 / 1.0625)
    expected = 20.0 / 3.0 * math.exp(-10.0 * slow)
    assert numbers["disagreement after 10 s with an index gain of 44460 [m]"] == pytest.approx(expected, rel=0.2)
    assert times["slow mode at gain 44460, with washout and low-pass [s]"] == pytest.approx(0.66, abs=0.005)


def test_theorem_one_loses_the_cross_terms() -> None:
    numbers = claims.theorem_1()
    assert numbers["dV/dt by the chain rule [m^2/s]"] == pytest.approx(0.0, abs=1e-12)
    assert numbers["dV/dt by (12) [m^2/s]"] == pytest.approx(-2.0)


def test_the_documents_name_every_claim_and_only_tests_and_code_that_exist() -> None:
    named = [set(re.findall(r"`fes claims ([a-z0-9-]+)`", text)) for text in (PAPER, TEAM)]
    assert named[1] == {"team-index"}
    assert named[0] | named[1] == set(claims.CLAIMS)
    tests = {path.stem for path in (ROOT / "tests").rglob("test_*.py")}
    assert set(re.findall(r"`(test_[a-z_]+)`", PAPER)) <= tests
    for module, functions in set(re.findall(r"`((?:fes|agents|world)\.[a-z_.]+)(?::([A-Za-z_]+))?`", PAPER)):
        imported = importlib.import_module(module)
        assert not functions or hasattr(imported, functions), f"{module}:{functions}"


def test_the_document_prints_the_numbers_that_the_claims_compute(disk: dict[str, float]) -> None:
    times, optima = claims.time_constant(), claims.two_exponents()
    text = PAPER.replace("\n", " ")
    for nearest in (50, 100):
        assert f"{times[f'1/(a^2 |J{chr(39)}{chr(39)}|/2) for r_min {nearest} [s]']:,.0f} s" in text
    for shape, nearest in ((4, 50), (4, 100), (3, 50), (3, 100), (2, 50), (2, 100)):
        assert f"{optima[f'r* with shape exponent {shape}, r_min {nearest} [m]']:.2f}" in text
    ends = re.search(r"shortest link ends between (\d+) and (\d+) m, the longest between (\d+) and (\d+) m", text)
    assert ends is not None
    for kind, least, most in (("shortest", *ends.groups()[:2]), ("longest", *ends.groups()[2:])):
        assert float(least) < disk[f"{kind} link, least over seeds [m]"]
        assert disk[f"{kind} link, most over seeds [m]"] < float(most)
    assert f"{20.0 / 3.0:.3f} m" in text
    assert f"{times['slow mode at gain 44460, with washout and low-pass [s]']:.2f} s" in text


def test_the_scenarios_that_the_claims_use_are_those_of_the_folder() -> None:
    assert claims._scenario("two_nearest") == load("paper.toml")
