"""fes check and the conformance kit: an extension that breaks a rule gets one line that names both."""

import math
import time

import pytest

from console.check import rules, subject
from console.check.rules import Finding
from fes.errors import FesError
from fes.extension.conformance import check
from tests.support import broken_laws, broken_worlds

LAW_RULES = [
    "interface", "values", "repeat", "alone", "crews", "stacked", "inputs", "state", "restart", "clock", "randomness",
    "hashing", "processes",
]  # fmt: skip
WORLD_RULES = [rule for rule in LAW_RULES if rule not in ("alone", "crews", "restart")]

RESUMED = "state: a run resumed from its state has other digits: keep all memory in the state: "

BROKEN = {
    broken_laws.WrongShape: "values: the pull must have shape [5, 2], got [5]",
    broken_laws.WrongType: "values: the pull must be of type float64, got float32",
    broken_laws.NotANumber: "values: the pull must be finite, got nan",
    broken_laws.Raises: "values: step: KeyError: 'nothing\\nthere'",
    broken_laws.WithoutParameters: "interface: its `Parameters` is not a subclass of `fes.extension.Table`",
    broken_laws.WritesInputs: "inputs: step writes to an array of its inputs or of its state, instead of returning a "
    "new one",
    broken_laws.WritesState: "inputs: step writes to an array of its inputs or of its state, instead of returning a "
    "new one",
    broken_laws.Unpicklable: "state: its state cannot be pickled: TypeError: cannot pickle '_thread.lock' object",
    broken_laws.ReadsClock: "clock: it reads a clock: time.time",
    broken_laws.ReadsImportedClock: "clock: it reads a clock: time.perf_counter",
    broken_laws.ReadsDate: "clock: it reads a clock: datetime.datetime.now",
    broken_laws.GlobalRandomness: "randomness: it takes random numbers that are not of its context: random.random",
    broken_laws.UnseededGenerator: "randomness: it takes random numbers that are not of its context: "
    "numpy.random.default_rng",
    broken_laws.TellsText: "values: step must return numbers, estimates by id and a list of statistics, got "
    "Action(move=Pull(x=0.0, y='far'), estimates={}, statistics=())",
    broken_worlds.MoreThanCertain: "values: the probability must be from 0 to 1, got 2",
    broken_worlds.WritesSeparation: "inputs: probability writes to an array of its inputs or of its state, instead "
    "of returning a new one",
    broken_worlds.BodiesWithGenerator: "state: its state cannot be in a checkpoint: UnpicklingError: "
    "numpy.random._pickle.__generator_ctor",
    broken_worlds.InfiniteMetric: "values: result must be finite or None, got InfiniteMetric.total = inf",
    broken_worlds.MetricWithLock: "state: its state cannot be in a checkpoint: TypeError: cannot pickle "
    "'_thread.lock' object",
}
"""Broken extension -> the line after its name."""

OTHER_DIGITS = {
    broken_laws.CountsCalls: "repeat: it computes other digits the second time: ",
    broken_laws.UsesCrewSize: "alone: robot 0 alone computes other digits than a crew of all: ",
    broken_laws.UsesSum: "crews: a crew of robots 0, 2, 4 computes other digits than a crew of all: ",
    broken_laws.UsesIds: "stacked: with seed 8 a stacked run and a run alone differ in ",
    broken_laws.HiddenMemory: RESUMED,
    broken_laws.RuleWithMemory: RESUMED,
    broken_laws.NeverForgets: "restart: a robot that forgets differs from a new one: ",
    broken_worlds.MetricOfSharedState: "repeat: it computes other digits the second time: ",
}
"""Extension whose digits depend on more than the scenario -> the start of the line after its name."""

OTHER_INTERPRETERS = {
    broken_laws.OrderOfSets: "hashing: with PYTHONHASHSEED=",
    broken_laws.OneLoopOnly: "processes: processes and one loop differ in ",
}


def title(value: object) -> str:
    return getattr(value, "__name__", "")


def first_failure(extension: type) -> Finding:
    """The first rule that an extension breaks."""
    return next(finding for finding in rules.findings(subject.of(extension)) if finding.failure)


def line(extension: type, text: str) -> str:
    chosen = subject.of(extension)
    return f"{chosen.kind.name} '{extension.__module__}:{extension.__name__}': {text}"


@pytest.mark.parametrize(("extension", "text"), BROKEN.items(), ids=title)
def test_a_broken_rule_is_one_line_that_names_the_extension_and_the_rule(extension: type, text: str) -> None:
    assert first_failure(extension).failure == line(extension, text)


@pytest.mark.parametrize(("extension", "text"), OTHER_DIGITS.items(), ids=title)
def test_digits_that_depend_on_more_than_the_scenario_are_found(extension: type, text: str) -> None:
    failure = first_failure(extension).failure
    assert failure.startswith(line(extension, text))
    assert "\n" not in failure


@pytest.mark.slow
@pytest.mark.parametrize(("extension", "text"), OTHER_INTERPRETERS.items(), ids=title)
def test_digits_that_depend_on_the_interpreter_are_found(extension: type, text: str) -> None:
    assert first_failure(extension).failure.startswith(line(extension, text))


@pytest.mark.slow
def test_rules_that_fail_only_because_repeat_fails_say_so() -> None:
    failures = {finding.rule: finding.failure for finding in rules.findings(subject.of(broken_laws.MovesByClock))}
    own = {rule: failures.pop(rule) for rule in ("repeat", "clock")}
    assert own["repeat"].startswith(
        line(broken_laws.MovesByClock, "repeat: it computes other digits the second time")
    )
    assert own["clock"] == line(broken_laws.MovesByClock, "clock: it reads a clock: time.time")
    follows = "it has other digits, which follows from the failure of `repeat`: correct that first"
    others = {rule: text for rule, text in failures.items() if text}
    assert others == {rule: line(broken_laws.MovesByClock, f"{rule}: {follows}") for rule in others}
    assert set(others) == {"alone", "crews", "stacked", "inputs", "state", "restart", "hashing", "processes"}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("extension", "expected"),
    [
        (broken_laws.Law, LAW_RULES),
        (broken_laws.Rule, LAW_RULES),
        (broken_worlds.Channel, WORLD_RULES),
        (broken_worlds.Bodies, WORLD_RULES),
        (broken_worlds.MetricWithNestedParameters, WORLD_RULES),
    ],
    ids=title,
)
def test_an_extension_that_keeps_all_rules_is_checked_against_each(extension: type, expected: list[str]) -> None:
    results = list(rules.findings(subject.of(extension)))
    assert [finding.rule for finding in results] == expected
    assert not [finding.failure for finding in results if finding.failure]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "parameters"),
    [
        ("agents.laws.neighbor_rules:RelativeNeighborhood", {}),
        ("agents.laws.seeking_measured:PooledSeeking", {"index": "measured"}),
        ("agents.laws.oracle:OracleSeeking", {}),
    ],
)
def test_a_built_in_law_keeps_the_rules_of_those_of_others(name: str, parameters: dict[str, str]) -> None:
    check(name, **parameters)


def test_the_kit_for_pytest_raises_an_assertion_with_one_line_per_broken_rule() -> None:
    with pytest.raises(AssertionError) as raised:
        check(broken_laws.WrongShape)
    assert str(raised.value) == line(broken_laws.WrongShape, BROKEN[broken_laws.WrongShape])


@pytest.mark.parametrize(
    ("name", "text"),
    [
        (
            "tests.support.broken_laws:Lawn",
            "extension 'tests.support.broken_laws:Lawn': module 'tests.support.broken_laws' has no class 'Lawn'; "
            "did you mean 'Law'?",
        ),
        (
            "tests.support.broken_laws:WithoutForget",
            "extension 'tests.support.broken_laws:WithoutForget': nearest is formation law, but it has no method "
            "`forget`",
        ),
        (
            "tests.support.broken_laws:Ambiguous",
            "extension 'tests.support.broken_laws:Ambiguous': it has the methods of formation law and of dynamics; "
            "choose with --kind",
        ),
        (
            "tests.support.broken_laws:Nothing",
            "extension 'tests.support.broken_laws:Nothing': it has no method of any kind of extension",
        ),
        (
            "no_such_module:Law",
            "--use no_such_module: ModuleNotFoundError: No module named 'no_such_module'",
        ),
        (
            "labs/flat.py:DeadBand",
            "extension 'labs/flat.py:DeadBand': a class is named by its module, not by a path: write 'flat:DeadBand' "
            "(--use labs/flat.py)",
        ),
        (
            "flocking",
            "extension 'flocking': none is installed under this name; a file is named by `module:Class`",
        ),
    ],
)
def test_an_extension_that_is_not_there_or_not_of_one_kind_is_one_line(name: str, text: str) -> None:
    with pytest.raises(FesError) as raised:
        check(name)
    assert str(raised.value) == text


def test_a_kind_that_does_not_exist_is_one_line() -> None:
    with pytest.raises(FesError) as raised:
        check(broken_laws.Law, "law")
    assert str(raised.value) == (
        "there is no kind 'law' of extension; known are controller, formation-law, seeking-law, neighbor-rule, "
        "channel, dynamics, metric"
    )


def test_a_class_within_a_function_is_rejected_because_no_other_process_could_import_it() -> None:
    class Local(broken_laws.Law):
        pass

    with pytest.raises(FesError, match=r"it must be in a module, not in a function or a script$"):
        check(Local)


def test_unknown_parameters_are_one_line_with_the_nearest_name() -> None:
    with pytest.raises(AssertionError) as raised:
        check(broken_laws.Law, gian=0.5)
    text = "interface: unknown parameter 'gian'; did you mean 'gain'?"
    assert str(raised.value) == line(broken_laws.Law, text)


def test_a_parameter_that_no_scenario_can_hold_is_one_line() -> None:
    with pytest.raises(AssertionError) as raised:
        check(broken_laws.Law, gain=math.inf)
    text = "interface: gain: must be a finite number, a text, true or false, a list or a table, got inf"
    assert str(raised.value) == line(broken_laws.Law, text)


def test_the_clock_works_again_after_a_check() -> None:
    first_failure(broken_laws.ReadsImportedClock)
    assert time.time() > 0.0
    assert vars(broken_laws)["perf_counter"] is time.perf_counter
