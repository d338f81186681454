"""fes check, as a person calls it: one line per rule, and an exit code."""

from pathlib import Path

import pytest

from tests.support.commands import call, complaint

LAW = """
import time

from fes.extension import Action, NoParameters, Pull


class Still:
    Parameters = NoParameters

    def __init__(self, parameters, context): ...

    def step(self, robot):
        return Action(Pull(0.0, 0.0))


class Late(Still):
    def step(self, robot):
        return Pull(0.0 * time.time(), 0.0)
"""
ROW = "{:8}{:12}{}"
KEPT = [
    ROW.format("ok", "interface", "it has the methods of its kind, and takes its parameters"),
    ROW.format("ok", "values", "results have the right shapes and types, and are finite"),
    ROW.format("ok", "repeat", "the same digits when repeated"),
    ROW.format("ok", "alone", "the same digits for a robot alone as in a crew of all"),
    ROW.format("ok", "crews", "the same digits in crews of 3 and 2 robots"),
    ROW.format("ok", "stacked", "the same digits in a stack of three runs"),
    ROW.format("ok", "inputs", "inputs and state are not written to"),
    ROW.format("ok", "state", "the state can be pickled, and a run resumed from it has the same digits"),
    ROW.format("ok", "restart", "a robot that restarts equals a new one"),
    ROW.format("ok", "clock", "no clock is read"),
    ROW.format("ok", "randomness", "no random numbers are used but those of the context"),
    ROW.format("ok", "hashing", "the same digits with another PYTHONHASHSEED"),
    ROW.format("ok", "processes", "the same digits in processes and in one loop"),
]


@pytest.fixture
def lab(tmp_path: Path) -> Path:
    (tmp_path / "mylab.py").write_text(LAW)
    return tmp_path


@pytest.mark.slow
def test_an_extension_that_keeps_the_rules_gets_a_line_per_rule_and_exit_code_0(lab: Path) -> None:
    done = call(lab, "fes", "check", "mylab:Still")
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.splitlines() == ["controller 'mylab:Still'", *KEPT]
    assert not (lab / "runs").exists()


@pytest.mark.slow
def test_a_controller_that_reads_the_clock_gets_a_line_and_exit_code_1(lab: Path) -> None:
    done = call(lab, "fes", "check", "mylab:Late")
    assert (done.returncode, done.stderr) == (1, "")
    broken = ROW.format("failed", "clock", "it reads a clock: time.time")
    assert done.stdout.splitlines() == [
        "controller 'mylab:Late'",
        *(broken if " clock " in line else line for line in KEPT),
    ]


def test_a_class_that_is_not_there_is_one_line(lab: Path) -> None:
    line = complaint(call(lab, "fes", "check", "mylab:Stil"), "fes")
    assert line == "extension 'mylab:Stil': module 'mylab' has no class 'Stil'; did you mean 'Still'?"
