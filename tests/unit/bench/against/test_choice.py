"""The rows that a command line names, and what a row shows that cannot be measured."""

from pathlib import Path

import pytest

from bench.against import budgets, choice, cores
from bench.against.cores import Core
from bench.against.plan import Plan, Row
from bench.against.programs import NotMeasured
from bench.against.table import Line, Wanted

NUMPY, BROKEN = Core("numpy", "numpy"), Core("c", "c", "the compiled core is not built")


def plan(*used: Core) -> Plan:
    return Plan(1, 1, True, Path("cache"), list(used))


def row(name: str, *groups: str, reason: str = "") -> Row:
    """A row with one number for each usable core, or one that cannot be measured for a reason."""

    def measure(of: Plan, own: Row) -> list[Line]:
        if reason:
            raise NotMeasured(reason)
        return [budgets.line(own.what, core, own.wanted, [3.0], [2.0], [1.5]) for core in budgets.usable(of)]

    return Row(name, groups, f"what {name} is", Wanted(2.0, 1.0), measure)


ROWS = [row("lockstep"), row("in_process", "old"), row("sweep", "vmas"), row("ready", "old")]


@pytest.mark.parametrize(
    ("only", "names", "with_details"),
    [
        (None, ["lockstep", "in_process", "sweep", "ready"], True),
        ("lockstep,old", ["lockstep", "in_process", "ready"], False),
        ("ready, vmas", ["sweep", "ready"], False),
        ("old,ready", ["in_process", "ready"], False),
        ("details", [], True),
        ("sweep,details", ["sweep"], True),
    ],
)
def test_names_and_groups_choose_rows_once_and_in_the_order_of_the_table(
    only: str | None, names: list[str], with_details: bool
) -> None:
    rows, details = choice.chosen(ROWS, only)
    assert ([picked.name for picked in rows], details) == (names, with_details)


@pytest.mark.parametrize("only", ["speed", "", "old,", "lockstep;old"])
def test_another_word_is_rejected_with_those_that_exist(only: str) -> None:
    with pytest.raises(ValueError, match=r"one of lockstep, in_process, sweep, ready, old, vmas, details, got"):
        choice.chosen(ROWS, only)


def test_a_core_that_is_not_built_gets_a_line_with_the_reason() -> None:
    missing, measured = choice.lines(ROWS[0], plan(BROKEN, NUMPY))
    assert missing.cells()[1] == "c"
    assert missing.cells()[4:6] == ("not measured: the compiled core is not built", "≥ 2")
    assert measured.cells() == ("what lockstep is", "numpy", "3", "2", "1.50 (1.50 to 1.50)", "≥ 1", "met")


def test_a_row_that_fails_gives_its_reason_for_each_core() -> None:
    other = Core("unset", "numpy")
    lines = choice.lines(row("sweep", reason="pip ended with 1"), plan(NUMPY, other))
    assert [line.cells()[4] for line in lines] == ["not measured: pip ended with 1"] * 2


def test_without_any_core_each_row_has_one_line() -> None:
    (line,) = choice.lines(ROWS[0], plan(BROKEN))
    assert line.reason == BROKEN.reason


@pytest.mark.parametrize(
    ("word", "reported", "name", "is_measured"),
    [
        ("c", "c", "c", True),
        ("c", "numpy", "c", False),
        ("numpy", "numpy", "numpy", True),
        ("unset", "numpy", "numpy", True),
        ("unset", "c", "c", True),
    ],
)
def test_a_core_is_named_as_a_process_reports_it(word: str, reported: str, name: str, is_measured: bool) -> None:
    core = cores.resolve(word, reported)
    assert (core.name, core.reason == "") == (name, is_measured)


def test_the_variable_of_an_unset_choice_is_removed() -> None:
    assert cores.variables("unset") == {"FES_CORE": None}
    assert cores.variables("numpy") == {"FES_CORE": "numpy"}


def test_the_table_has_each_budget_once() -> None:
    names = [row.name for row in budgets.ROWS]
    assert len(set(names)) == len(names)
    bounds = {row.name: (row.wanted.compiled, row.wanted.numpy, row.wanted.at_least) for row in budgets.ROWS}
    assert bounds == {
        "lockstep": (0.75, 0.35, True),
        "in_process": (4.0, 0.5, True),
        "recording": (0.8, 0.8, True),
        "moving": (2.0, 2.0, True),
        "stack": (1.5, 1.5, True),
        "sweep": (1.5, 1.5, True),
        "sizes": (1.5, 1.5, False),
        "ready": (0.5, 0.5, False),
    }
