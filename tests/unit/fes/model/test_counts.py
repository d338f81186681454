"""Counts that come from two settings: for any settings, a rule refuses them or the work is bounded."""

import ast
import itertools
import math
from argparse import ArgumentTypeError
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.control import crew
from agents.laws.seeking_perturbation import PerturbationSeeking
from console.backends import inprocess
from fes.command_line import real_time_factor
from fes.errors import FesError, ScenarioError
from fes.model import counts, seeking
from fes.model.config import AgentConfig
from fes.model.seeking import OracleConfig
from tests.support.loop import load
from tests.support.paths import ROOT
from world.config.scenario import Scenario, agent_config
from world.metrics import collector

SMALLEST, LARGEST = 5e-324, 1.7e308
EXTREMES = (SMALLEST, 1e-300, 1e-9, 1e9, 1e300, LARGEST)
FIELDS = (
    "run.dt",
    "run.duration",
    "seeking.sub_step",
    "seeking.dither_frequency",
    "formation.contact_timeout",
    "channel.bursts.mean_length",
    "event.at",
    "event.transmitter.delay",
)
POSITIVE = st.floats(min_value=SMALLEST, max_value=LARGEST)


def tables(index: str, fields: dict[str, float]) -> dict[str, Any]:
    """Overrides of pair.toml."""
    event = {"at": fields.pop("event.at", 0.0), "set": {"channel.reference_snr": 1e6}}
    late = {"at": 0.0, "transmitter": {"robot": 0, "delay": fields.pop("event.transmitter.delay", 0.0)}}
    result: dict[str, Any] = {"seeking.index": index, "event": [event, late], "seeking.consensus_gain": 1e-3}
    if "channel.bursts.mean_length" in fields:
        result["channel.bursts.bad_share"] = 0.1
    return result | fields


def loaded(overrides: dict[str, Any]) -> Scenario | None:
    """The scenario, or None where it is refused in one line."""
    refused = []
    try:
        return load("pair.toml", **overrides)
    except ScenarioError as error:
        refused.append(str(error))
    assert "\n" not in refused[0]
    return None


@pytest.mark.parametrize("index", ["oracle", "measured"])
@pytest.mark.parametrize(("one", "other"), list(itertools.combinations(FIELDS, 2)))
def test_extremes_of_two_settings_are_rejected_in_one_line_or_run_in_bounded_work(
    one: str, other: str, index: str
) -> None:
    for values in itertools.product(EXTREMES, EXTREMES):
        scenario = loaded(tables(index, dict(zip((one, other), values, strict=True))))
        if scenario is None:
            continue
        assert 1 <= scenario.ticks <= seeking.MAX_TICKS
        assert 1 <= collector.dither_period(scenario) <= seeking.MAX_TICKS
        robots = crew.create(agent_config(scenario), np.arange(2))
        if index == "oracle":
            assert isinstance(robots.seeking, PerturbationSeeking)
            assert robots.seeking.seeker.sub_steps <= seeking.MAX_STEPS
        assert robots.contact_timeout <= counts.LARGEST
        assert all(fault.delay <= 10_000 for fault in scenario.faults)
        assert len(list(itertools.islice(inprocess.ticks(scenario), 2))) == min(2, scenario.ticks)


@pytest.mark.parametrize(
    ("field", "value", "said"),
    [
        ("run.dt", 1e-308, "run.dt: must be greater than or equal to 0.000001, got 1e-308"),
        ("run.dt", SMALLEST, "run.dt: must be greater than or equal to 0.000001, got 5e-324"),
        ("run.dt", 3600.0, "run.dt: must be less than or equal to 1000, got 3600.0"),
        ("run.duration", 1e300, "run.duration: must be less than or equal to 1000000000, got 1e+300"),
        ("run.duration", 9e8, "run: duration / dt must be at most 1e+09, got 4.5e+10"),
        ("seeking.sub_step", 1e-9, "run.dt / seeking.sub_step must be at most 10000, got 2e+07"),
        ("seeking.sub_step", 1e-300, "run.dt / seeking.sub_step must be at most 10000, got 2e+298"),
        ("seeking.sub_step", SMALLEST, "run.dt / seeking.sub_step must be at most 10000, got inf"),
    ],
)
def test_a_setting_that_needs_endless_work_is_rejected(field: str, value: float, said: str) -> None:
    with pytest.raises(ScenarioError) as refused:
        load("pair.toml", **{field: value})
    assert str(refused.value).endswith(f"pair.toml: {said}")


def test_a_physical_dither_with_an_infinite_period_is_rejected() -> None:
    with pytest.raises(ScenarioError, match=r"period of seeking\.dither_frequency / run\.dt must be at most 1e\+09"):
        load("measured.toml", seeking__dither_frequency=1e-300)
    load("pair.toml", seeking__dither_frequency=1e-300)  # an oracle's estimates dither, its robots do not


def test_a_crew_rejects_settings_that_the_world_should_have_rejected() -> None:
    config = agent_config(load("pair.toml"))
    endless = config.model_copy(update={"seeking": OracleConfig(sub_step=1e-9)})
    with pytest.raises(FesError, match=r"^the run's settings: run\.dt / seeking\.sub_step must be at most 10000"):
        crew.create(AgentConfig.model_validate(endless.model_dump()), np.arange(2))


@given(time=POSITIVE, step=POSITIVE)
def test_a_count_is_a_bounded_integer_for_all_floats(time: float, step: float) -> None:
    result = (counts.ticks(time, step), counts.ticks_within(time, step), counts.ticks_of(time, step))
    assert all(0 <= count <= counts.LARGEST for count in result)
    assert 1 <= counts.steps(time, step) <= counts.LARGEST


@given(count=st.integers(1, 10**6), dt=st.floats(1e-6, 1e3))
def test_a_count_is_exact_for_multiples_of_a_tick(count: int, dt: float) -> None:
    assert counts.ticks(count * dt, dt) == count
    assert counts.ticks_within((count - 0.5) * dt, dt) == count
    assert counts.steps(count * dt, dt) == count  # the product's own rounding makes no step more


def test_a_pace_too_slow_for_a_sleep_is_rejected() -> None:
    with pytest.raises(ArgumentTypeError, match="at least 1e-06, got '1e-300'"):
        real_time_factor("1e-300")
    assert real_time_factor("0.5") == 0.5


def test_only_one_function_computes_counts() -> None:
    """No other module rounds a quotient by a tick or a step."""
    divisors, rounding = {"dt", "_dt", "sub_step", "dither_frequency"}, {"round", "ceil", "floor", "int"}
    result = []
    for path in itertools.chain.from_iterable(
        (ROOT / room).rglob("*.py") for room in ("fes", "agents", "world", "field")
    ):
        if path == ROOT / "fes" / "model" / "counts.py":
            continue
        for call in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            name = getattr(call, "func", None)
            if getattr(name, "id", getattr(name, "attr", None)) not in rounding:
                continue
            result += [
                f"{path}:{part.lineno}"
                for part in ast.walk(call)
                if isinstance(part, ast.BinOp)
                and isinstance(part.op, ast.Div)
                and getattr(part.right, "attr", getattr(part.right, "id", None)) in divisors
            ]
    assert result == []


def test_the_ratio_of_two_floats_may_be_infinite() -> None:
    assert counts.ratio(1.0, SMALLEST) == math.inf
    assert counts.ratio(1.0, 0.0) == math.inf
