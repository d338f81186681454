"""Extensions that do not work: a run of them ends with one line that names the extension, the rule and the value."""

from pathlib import Path
from typing import Any

import pytest

from console.backends import inprocess
from fes.errors import FesError, ScenarioError
from fes.extension import registry
from world.config import scenario
from world.config.scenario import Scenario
from world.execution.checkpoint import CheckpointWriter
from world.execution.run import Run

LAWS, WORLDS = "tests.support.broken_laws", "tests.support.broken_worlds"
RUNS = "tests.support.broken_in_runs"

READ_ONLY = "ValueError: output array is read-only"


@pytest.fixture(autouse=True)
def _modules() -> None:
    registry.use(LAWS)
    registry.use(WORLDS)
    registry.use(RUNS)


def with_extension(**tables: Any) -> Scenario:
    """A run of 1 s with these tables."""
    short = {"schema": 1, "run": {"duration": 1.0}, "robots": {"count": 3}, "seeking": {"index": "measured"}}
    return scenario.parse({**short, **tables}, "lab.toml")


@pytest.mark.parametrize(
    ("tables", "text"),
    [
        (
            {"formation": {"law": f"{LAWS}:Lawn"}},
            f"formation.law: formation law '{LAWS}:Lawn': module '{LAWS}' has no class 'Lawn'; did you mean 'Law'?",
        ),
        (
            {"formation": {"law": "papers"}},
            "formation.law: there is no formation law 'papers'; did you mean 'paper'?",
        ),
        (
            {"formation": {"law": {"use": f"{LAWS}:Law", "gian": 1.0}}},
            f"formation.law: formation law '{LAWS}:Law': unknown parameter 'gian'; did you mean 'gain'?",
        ),
        (
            {"formation": {"law": {"use": f"{LAWS}:Law", "gain": "much"}}},
            f"formation.law: formation law '{LAWS}:Law': gain: must be a valid number",
        ),
        (
            {"formation": {"law": f"{LAWS}:WithoutForget"}},
            f"formation.law: formation law '{LAWS}:WithoutForget': it has no method `forget`",
        ),
        (
            {"formation": {"rule": f"{LAWS}:WithoutParameters"}},
            f"formation.rule: neighbor rule '{LAWS}:WithoutParameters': its `Parameters` is not a subclass of "
            "`fes.extension.Table`",
        ),
        (
            {"channel": {"model": f"{WORLDS}:Metric"}},
            f"channel.model: channel '{WORLDS}:Metric': it has no method `probability`",
        ),
        (
            {"formation": {"law": "somewhere:Law"}},
            "formation.law: formation law 'somewhere:Law': this process was not told to use module 'somewhere' "
            "(--use somewhere)",
        ),
        (
            {"formation": {"law": "flat.py:Law"}},
            "formation.law: formation law 'flat.py:Law': a class is named by its module, not by a path: write "
            "'flat:Law' (--use flat.py)",
        ),
        (
            {"formation": {"law": "labs/flat:Law"}},
            "formation.law: formation law 'labs/flat:Law': a class is named by its module, not by a path: write "
            "'flat:Law' (--use labs/flat.py)",
        ),
    ],
)
def test_a_scenario_that_names_no_working_extension_is_rejected_in_one_line(tables: Any, text: str) -> None:
    with pytest.raises(ScenarioError) as raised:
        with_extension(**tables)
    assert str(raised.value) == f"lab.toml: {text}"


@pytest.mark.parametrize(
    ("tables", "text"),
    [
        (
            {"formation": {"law": f"{LAWS}:WrongShape"}},
            f"formation law '{LAWS}:WrongShape': the pull must have shape [3, 2], got [3]",
        ),
        (
            {"formation": {"law": f"{LAWS}:NotANumber"}},
            f"formation law '{LAWS}:NotANumber': the pull must be finite, got nan",
        ),
        (
            {"formation": {"law": f"{LAWS}:Raises"}},
            f"formation law '{LAWS}:Raises': step: KeyError: 'nothing\\nthere'",
        ),
        (
            {"channel": {"model": f"{WORLDS}:MoreThanCertain"}},
            f"channel '{WORLDS}:MoreThanCertain': the probability must be from 0 to 1, got 2",
        ),
        (
            {"robots": {"count": 3, "controller": f"{LAWS}:TellsText"}},
            f"controller '{LAWS}:TellsText': step must return numbers, estimates by id and a list of statistics, got "
            "Action(move=Pull(x=0.0, y='far'), estimates={}, statistics=())",
        ),
        (
            {"formation": {"law": f"{RUNS}:PushesBodies"}},
            f"formation law '{RUNS}:PushesBodies': step: {READ_ONLY}",
        ),
        (
            {"metric": [{"use": f"{RUNS}:CentersPoses"}]},
            f"metric '{RUNS}:CentersPoses': add: {READ_ONLY}",
        ),
        *(
            ({"metric": [{"use": f"{RUNS}:{name}"}]}, f"metric '{RUNS}:{name}': add: {READ_ONLY}")
            for name in ("StopsRobots", "RemovesRobot", "RestartsContacts")
        ),
        (
            {"seeking": {"use": f"{RUNS}:NegativePeriod", "separation": 60.0}},
            f"seeking law '{RUNS}:NegativePeriod': physical_period must return a positive time or None, got -3.0",
        ),
        (
            {"seeking": {"use": f"{RUNS}:PeriodInWords", "separation": 60.0}},
            f"seeking law '{RUNS}:PeriodInWords': physical_period must return a positive time or None, got '1 s'",
        ),
        (
            {"seeking": {"use": f"{RUNS}:EndlessPeriod", "separation": 60.0}},
            "seeking: the law's physical_period / run.dt must be at most 1e+09, got 5e+301",
        ),
    ],
)
def test_a_result_that_breaks_the_interface_ends_a_run_in_one_line(tables: Any, text: str) -> None:
    with pytest.raises(FesError) as raised:
        inprocess.run(with_extension(**tables), "lab")
    assert str(raised.value) == text


@pytest.mark.parametrize(
    ("tables", "text"),
    [
        (
            {"metric": [{"use": f"{WORLDS}:MetricWithLock"}]},
            f"metric '{WORLDS}:MetricWithLock': its state cannot be in a checkpoint: TypeError: cannot pickle "
            "'_thread.lock' object",
        ),
        (
            {"robots": {"count": 3, "dynamics": f"{WORLDS}:BodiesWithGenerator"}},
            f"dynamics '{WORLDS}:BodiesWithGenerator': its state cannot be in a checkpoint: UnpicklingError: "
            "numpy.random._pickle.__generator_ctor",
        ),
    ],
)
def test_a_state_that_no_checkpoint_can_hold_is_reported_before_the_first_tick(
    tables: Any, text: str, tmp_path: Path
) -> None:
    writer = CheckpointWriter(tmp_path, 10.0, "lab", "fes")
    run = Run(with_extension(**tables), note=writer.note)
    with pytest.raises(FesError) as raised:
        writer.begin(run)
    writer.close(run)
    assert str(raised.value) == text


def test_a_metric_that_fails_at_the_end_costs_only_its_own_numbers(caplog: pytest.LogCaptureFixture) -> None:
    metrics = [{"use": f"{RUNS}:FailsAtTheEnd"}, {"use": f"{WORLDS}:Metric"}]
    summary = inprocess.run(with_extension(metric=metrics), "lab")
    assert summary["metrics"] == {"FailsAtTheEnd": {}, "Metric": {"total": summary["metrics"]["Metric"]["total"]}}
    assert summary["metrics"]["Metric"]["total"] > 0.0
    assert caplog.messages == [
        f"metric '{RUNS}:FailsAtTheEnd': result: ZeroDivisionError: float division by zero; "
        "the summary has none of its numbers"
    ]


def test_a_metric_that_fails_at_the_first_tick_leaves_a_summary_of_it() -> None:
    kept: list[dict[str, Any]] = []
    with pytest.raises(FesError) as raised:
        inprocess.run(with_extension(metric=[{"use": f"{RUNS}:FailsAtOnce"}]), "lab", keep=kept.append)
    assert str(raised.value) == f"metric '{RUNS}:FailsAtOnce': add: ValueError: no numbers"
    assert [summary["ticks"] for summary in kept] == [1]
