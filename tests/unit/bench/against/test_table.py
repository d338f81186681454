"""The table of budgets: medians, spreads, bounds by core, and reasons for what was not measured."""

import pytest

from bench.against import rounds
from bench.against.table import HEADER, Line, Wanted, amount, markdown

FASTER = Wanted(4.0, 0.5)
SMALLER = Wanted(60.0, 60.0, at_least=False, unit=" MB")


def line(*values: float, wanted: Wanted = FASTER, is_compiled: bool = False) -> Line:
    """A line with a ratio per round."""
    return Line("rate", "numpy", wanted, is_compiled, (100.0,) * len(values), (50.0,) * len(values), values)


def test_a_row_shows_the_medians_and_the_spread_of_its_rounds() -> None:
    row = Line("rate", "numpy", FASTER, False, (1200.0, 900.0, 1000.0), (0.5, 0.25, 0.125), (0.7, 0.4, 0.6))
    assert row.cells() == ("rate", "numpy", "1,000", "0.25", "0.60 (0.40 to 0.70)", "≥ 0.5", "met")


def test_the_bound_is_that_of_the_core_in_use() -> None:
    assert line(1.0).cells()[-2:] == ("≥ 0.5", "met")
    assert line(1.0, is_compiled=True).cells()[-2:] == ("≥ 4", "**not met**")


@pytest.mark.parametrize(("value", "verdict"), [(59.9, "met"), (60.0, "met"), (60.1, "**not met**")])
def test_an_upper_bound_includes_its_value(value: float, verdict: str) -> None:
    assert line(value, wanted=SMALLER).cells()[-2:] == ("≤ 60 MB", verdict)


def test_a_quantity_has_its_unit() -> None:
    assert line(58.0, 62.0, 61.0, wanted=SMALLER).cells()[4] == "61 MB (58 to 62)"


def test_the_median_decides_and_not_the_best_round() -> None:
    assert line(0.4, 0.45, 9.0).cells()[-1] == "**not met**"


def test_a_row_without_numbers_gives_its_reason_and_no_verdict() -> None:
    missing = Line("rate", "c", FASTER, True, reason="the compiled core is not built")
    assert missing.cells() == ("rate", "c", "", "", "not measured: the compiled core is not built", "≥ 4", "")


def test_every_row_of_the_table_has_the_columns_of_its_header() -> None:
    missing = Line("rate", "c", FASTER, True, reason="a | b")
    text = markdown([line(1.0), missing])
    assert [row.replace("\\|", "").count("|") for row in text.splitlines()] == [len(HEADER) + 1] * 4
    assert text.startswith("| what | core | fes | other |")


def test_both_sides_are_measured_in_turn_and_in_reverse_in_every_other_round() -> None:
    order: list[str] = []

    def side(name: str) -> float:
        order.append(name)
        return float(len(order))

    measured = rounds.alternate({"a": lambda: side("a"), "b": lambda: side("b")}, 3)
    assert "".join(order) == "abbaab"
    assert measured == {"a": [1.0, 4.0, 5.0], "b": [2.0, 3.0, 6.0]}
    assert rounds.ratios(measured["a"], measured["b"]) == [0.5, 4.0 / 3.0, 5.0 / 6.0]


def test_amounts_have_about_three_digits() -> None:
    printed = [amount([1234.6, 1300.0, 99.0]), amount([0.2345]), amount([12.34]), amount([])]
    assert printed == ["1,235", "0.234", "12.3", ""]
