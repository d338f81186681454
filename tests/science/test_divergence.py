"""Unstable settings are rejected, or run without a warning to a summary that reports lost links."""

import itertools
import types
from collections.abc import Iterator
from typing import Annotated, Any, Union, get_args, get_origin

import numpy as np
import pytest
from rich.console import Console

from agents.control import motion
from agents.laws import collocation, formation, packet_counting
from console.backends import inprocess
from console.dashboard import summary
from fes.arrays import geometry
from fes.arrays.edges import Edges
from fes.arrays.types import Floats
from fes.errors import FesError, ScenarioError
from fes.model import kinematics, seeking
from fes.model.config import FormationConfig
from fes.model.table import Table
from tests.support.loop import load
from world.config.scenario import Scenario
from world.metrics import summary as summaries
from world.metrics.collector import MetricsCollector

SMALLEST, LARGEST = 5e-324, 1.7e308
PAIR = Edges(np.array([0, 1]), np.array([0, 1]), np.array([1, 0]))


def numbers(model: type[Table], prefix: str = "") -> Iterator[str]:
    """The dotted paths of all fields of a scenario that are one number or more."""
    for name, field in model.model_fields.items():
        for kind in _kinds(field.annotation):
            if isinstance(kind, type) and issubclass(kind, Table):
                yield from numbers(kind, f"{prefix}{name}.")
            elif kind is float:
                yield prefix + name


def _kinds(annotation: Any) -> list[Any]:
    """The alternatives of a type, without lists: other tests set their items."""
    if get_origin(annotation) is Annotated:
        return _kinds(get_args(annotation)[0])
    if get_origin(annotation) in (Union, types.UnionType):
        return [kind for part in get_args(annotation) for kind in _kinds(part)]
    return [annotation]


FIELDS = sorted({*numbers(Scenario), "seeking.initial_estimate"} - {"run.duration"})
REQUIRED: dict[str, dict[str, Any]] = {
    "channel.shadowing.": {"channel.shadowing.deviation": 6.0},
    "channel.bursts.": {"channel.bursts.bad_share": 0.1, "channel.bursts.mean_length": 1.0},
    "robots.": {"robots": {"count": 4}},
}
"""Other fields that a table needs."""


def after(gain_per_tick: float, ticks: int) -> Floats:
    """Errors [ticks] of the separation of two robots on a line, by the law and the exact motion of the unicycle."""
    dt, wanted = 0.02, 70.0
    config = FormationConfig(linear_gain=gain_per_tick / dt)
    poses, errors = np.array([[0.0, 0.0, 0.0], [80.0, 0.0, np.pi]]), []
    for _ in range(ticks):
        apart = poses[1, 0] - poses[0, 0]
        errors.append(apart - wanted)
        bearing = np.array([[1.0, -1.0], [0.0, 0.0]])
        vector = formation.formation_vector(PAIR, np.full(2, apart - wanted), bearing)
        poses = kinematics.move(poses, motion.twist(vector, poses[:, geometry.HEADING], dt, config), dt)
    return np.array(errors)


@pytest.mark.parametrize("gain_per_tick", [0.02, 0.5, 1.0, 1.5, 1.98, 2.02])
def test_two_robots_keep_one_minus_mu_dt_of_their_error(gain_per_tick: float) -> None:
    errors = after(gain_per_tick, 5)
    assert errors == pytest.approx(10.0 * (1.0 - gain_per_tick) ** np.arange(5), abs=1e-9)
    assert (abs(errors[-1]) > 10.0) == (gain_per_tick >= 2.0)  # the bound of the rule


@pytest.mark.parametrize(("gain", "dt"), [(100.0, 0.02), (1000.0, 0.02), (2.0, 1.0), (1e308, 0.02)])
def test_a_linear_gain_that_cannot_be_stable_is_rejected(gain: float, dt: float) -> None:
    with pytest.raises(
        ScenarioError, match=r"formation\.linear_gain x run\.dt must be below 2, got .*cannot be stable"
    ):
        load("pair.toml", formation__linear_gain=gain, run__dt=dt)
    load("pair.toml", formation__linear_gain=0.99 * 2.0 / dt, run__dt=dt)


@pytest.mark.parametrize("learning", [0.0, 0.3, 1.0, 1.9])
@pytest.mark.parametrize("mixing", [0.1, 0.5, 0.95, 1.05, 1.5])
def test_the_disagreement_of_a_measured_pair_dies_out_iff_kappa_dt_is_below_one(
    learning: float, mixing: float
) -> None:
    """The recursion of `MeasuredConfig.check`, executed, not solved: `mixing` is kappa dt, `learning` is g dt."""
    before, now = 1.0, 1.0
    for _ in range(4000):
        before, now = now, (1.0 - mixing - learning) * now - mixing * before
        if abs(now) > 1e9:
            break
    assert (abs(now) + abs(before) < 1e-9) == (mixing < 1.0)


def test_gains_of_a_measured_index_that_cannot_be_stable_are_rejected() -> None:
    with pytest.raises(
        ScenarioError, match=r"seeking\.consensus_gain x run\.dt of a measured index must be below 1, got 1"
    ):
        load("measured.toml", run__dt=0.25)
    with pytest.raises(ScenarioError, match=r"0\.3 /s x run\.dt of a measured index must be below 2, got 2\.1"):
        load("measured.toml", run__dt=7.0, seeking__consensus_gain=0.0, formation__linear_gain=0.1)
    load("measured.toml", run__dt=0.24)
    assert max(method.gain for method in (packet_counting.POOLED, packet_counting.ALONE)) == seeking.NEWTON


@pytest.mark.parametrize(("cutoff", "error"), [(seeking.MAX_WASHOUT, 1e-8), (2.0 * seeking.MAX_WASHOUT, 1e-3)])
def test_the_washout_is_integrated_exactly_up_to_its_bound(cutoff: float, error: float) -> None:
    """eta' = cutoff (1 - eta) from 0 reaches 1 - e^-cutoff after a second."""
    step = collocation.step(1.0, 0.5, cutoff, 0.5, 1.0)
    missed = abs(float(step.washout_input[-1].sum()) - (1.0 - np.exp(-cutoff)))
    assert error / 1e3 < missed < error


def test_a_washout_that_cannot_be_integrated_accurately_is_rejected() -> None:
    with pytest.raises(
        ScenarioError, match=r"washout_cutoff x a step of the integration must be at most 100, got 200"
    ):
        load("pair.toml", seeking__washout_cutoff=1e4)
    load("pair.toml", seeking__washout_cutoff=1e4, seeking__sub_step=0.01)


@pytest.mark.parametrize(
    ("field", "index"),
    [
        *itertools.product(FIELDS, ("oracle", "measured")),
        *((field, "sampled") for field in FIELDS if field.startswith(("seeking.", "objective."))),
    ],
)
def test_no_setting_makes_numpy_warn(field: str, index: str) -> None:
    """Each number of a scenario, far below and far above sensible values; a warning is an error here."""
    transform = "none" if index == "sampled" else "log"
    for value in (SMALLEST, 1e-9, 1e9, LARGEST):
        given = [value, value] if field == "seeking.initial_estimate" else value
        more = next((tables for start, tables in REQUIRED.items() if field.startswith(start)), {})
        error = error_of({"seeking.index": index, "seeking.index_transform": transform, **more, field: given})
        assert "\n" not in error


def error_of(settings: dict[str, Any]) -> str:
    """Run six ticks of the pair to their summary; the error, or an empty text."""
    try:
        scenario = load("pair.toml", **settings)
        metrics = MetricsCollector(scenario)
        for tick in itertools.islice(inprocess.ticks(scenario), 6):
            metrics.add(tick.state, tick.twists, tick.telemetry)
        summaries.summarize(metrics, "pair", "inprocess", 1.0)
    except FesError as error:
        return str(error)
    return ""


@pytest.mark.parametrize("amplitude", [3.5, 5.0, 10.0, 60.0])
def test_a_dither_far_too_large_runs_without_a_warning(amplitude: float) -> None:
    result = inprocess.run(load("paper.toml", run__duration=4.0, seeking__dither_amplitude=amplitude), "paper")
    assert result["estimate_error_max"] > 1.0


def links_by_tick(scenario: Scenario) -> list[int]:
    """Number of links at each tick."""
    return [len(tick.telemetry.links) for tick in inprocess.ticks(scenario)]


def test_the_summary_of_a_diverging_team_has_the_time_of_its_last_link() -> None:
    scenario = load(
        "pair.toml", run__duration=4.0, seeking__index_gain=1e10, expect=[{"of": "links_lost_at", "below": 4}]
    )
    links, result = links_by_tick(scenario), inprocess.run(scenario, "pair")
    last = max(tick for tick, count in enumerate(links) if count)
    assert 0 < last < len(links) - 1
    assert result["links_lost_at"] == pytest.approx((last + 1) * 0.02)
    assert result["expectations"][0]["holds"]
    line = f"all links were lost permanently at {result['links_lost_at']:g} s: no robot has had one since"
    assert line in summaries.lines(result)
    paper = Console(width=200)
    with paper.capture() as shown:
        paper.print(summary.render(result))
    assert line in shown.get()


def test_a_team_that_keeps_its_links_has_lost_none() -> None:
    assert inprocess.run(load("pair.toml", run__duration=1.0), "pair")["links_lost_at"] is None


def test_a_team_that_never_had_a_link_lost_it_at_the_start() -> None:
    result = inprocess.run(load("pair.toml", run__duration=1.0, channel__path_loss_exponent=6.0), "pair")
    assert result["links_lost_at"] == 0.0
    assert "no robot ever had a link" in summaries.lines(result)


def test_a_robot_alone_has_no_links_to_lose() -> None:
    alone = load("pair.toml", run__duration=0.2, robots={"count": 1})
    assert inprocess.run(alone, "pair")["links_lost_at"] is None


def test_links_that_return_are_not_lost() -> None:
    gone = [{"at": 1.0, "kill": [0, 1]}, {"at": 2.0, "restart": [0, 1]}]
    back = load("pair.toml", run__duration=3.0, event=gone)
    links, result = links_by_tick(back), inprocess.run(back, "pair")
    assert 0 in links[60:90]
    assert result["links_lost_at"] is None
    result = inprocess.run(load("pair.toml", run__duration=3.0, event=gone[:1]), "pair")
    assert result["links_lost_at"] == pytest.approx(1.0)
