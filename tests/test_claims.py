"""The numbers of docs/paper.md, as `fes claims` computes them."""

import re
from pathlib import Path

import pytest

from console import claims
from tests.loop import load

PAPER = (Path(__file__).parent.parent / "docs" / "paper.md").read_text()


def test_the_printed_law_freezes_a_disagreement_at_one_third() -> None:
    found = claims.printed_law()
    # The gradient, at its time constant of half a day, moves the estimates by some millimeters in 10 s.
    assert found["disagreement after 10 s [m]"] == pytest.approx(20.0 / 3.0, abs=0.002)
    assert found["change of beta_l r_hat + xi"] < 0.01


def test_the_corrected_law_agrees_with_the_eigenvalues_by_hand() -> None:
    found = claims.corrected_law()
    assert found["disagreement after 4 s [m]"] < 20.0 * 2.718281828 ** (-6.0 * 4.0) * 100.0
    # lambda^2 + 12 lambda + 64 = 0, and lambda^2 + 12 lambda = 0 as printed
    assert found["eigenvalues, real part [1/s]"] == pytest.approx(-6.0)
    assert found["eigenvalues, imaginary part [rad/s]"] == pytest.approx(28.0**0.5)
    assert found["printed law, largest eigenvalue [1/s]"] == pytest.approx(0.0, abs=1e-9)
    assert found["printed law, smallest eigenvalue [1/s]"] == pytest.approx(-12.0)


def test_the_printed_gains_take_half_a_day() -> None:
    # From J'' = -1.12460e-3 and -4.59919e-4 of the settled figures: 50 / |J''|.
    assert list(claims.time_constant().values()) == pytest.approx([50.0 / 1.12460e-3, 50.0 / 4.59919e-4], rel=1e-4)


def test_only_exponents_four_and_three_give_the_optima_of_figure_three() -> None:
    found = claims.two_exponents()
    right = {name for name, best in found.items() if round(best) in (68, 105)}
    assert {name for name in right if "r_min 100" in name} == {"r* with shape exponent 4, r_min 100 [m]"}
    assert "r* with shape exponent 4, r_min 50 [m]" in right


def test_weights_leave_nothing_for_the_robot_itself_and_are_not_symmetric() -> None:
    found = claims.weights()
    assert found["a_ii by (1), three neighbors"] == 0.0
    assert found["sum of weights, one neighbor"] == 0.5
    assert found["a_ij of a robot with three neighbors"] != found["a_ji of its peer with two"]


def test_the_disk_graph_is_frustrated_and_two_nearest_starts_in_two_parts() -> None:
    disk, parts = claims.disk_graph(), claims.two_parts()
    assert disk["links"] == 45.0
    assert disk["shortest [m]"] < 40.0
    assert disk["longest [m]"] > 95.0
    assert parts["two_nearest: links always connected"] == 0.0
    assert parts["relative_neighborhood: links always connected"] == 1.0
    assert parts["relative_neighborhood: largest error of a link at the end [m]"] <= 0.0011


def test_the_document_names_every_claim_and_only_tests_and_code_that_exist() -> None:
    named = set(re.findall(r"`fes claims ([a-z-]+)`", PAPER))
    assert named == set(claims.CLAIMS)
    root = Path(__file__).parent
    for name in set(re.findall(r"`(test_[a-z_]+)`", PAPER)):
        assert (root / f"{name}.py").exists(), name
    for room, module in set(re.findall(r"`(fes|agents|world)\.([a-z]+)(?::|`)", PAPER)):
        assert (root.parent / room / f"{module}.py").exists(), f"{room}.{module}"


def test_the_scenarios_that_the_claims_use_are_those_of_the_folder() -> None:
    assert claims._scenario("two_nearest") == load("paper.toml")
