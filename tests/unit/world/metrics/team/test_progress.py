"""The team index of a run: equal in every backend and with observers, and only in runs that ask for it."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from console.backends import inprocess, stacked
from fes.errors import ScenarioError
from fes.model import quantities
from tests.support.loop import load
from world.config.scenario import Scenario
from world.metrics import report_builder
from world.metrics.collector import MetricsCollector
from world.metrics.summary import summarize
from world.metrics.team import delivery, progress
from world.metrics.team.progress import TeamProgress
from world.metrics.team.team_index import team_index

TEAM = ("team_index", "team_index_target", "cutting_robots", "covered_area", "delivery_after_loss")


def short(**overrides: Any) -> Scenario:
    """A run of the paper's start in which a robot dies and the channel changes."""
    events = [{"at": 1.5, "kill": [9]}, {"at": 2.2, "set": {"channel.reference_snr": 5e6}}]
    return load("team-paper-start.toml", run__duration=3.0, event=events, expect=[], **overrides)


def without_machine(summary: dict[str, Any]) -> dict[str, Any]:
    """The summary without the wall clock."""
    return {key: value for key, value in summary.items() if key not in ("wall_s", "ticks_per_s", "real_time_factor")}


def test_a_stacked_run_has_the_team_index_of_a_single_one() -> None:
    single = [inprocess.run(short(run__seed=seed), "x") for seed in (1, 2)]
    together = stacked.run([short(run__seed=seed) for seed in (1, 2)], "x")
    assert [without_machine(summary) for summary in together] == [without_machine(summary) for summary in single]
    assert single[0]["team_index"] > 0.0


def test_observers_change_no_number_of_the_summary() -> None:
    alive = np.ones(10, dtype=np.uint8)
    scenario = short()
    watched, alone = MetricsCollector(scenario), MetricsCollector(scenario)
    for tick in inprocess.ticks(scenario):
        for metrics in (watched, alone):
            metrics.add(tick.state, tick.twists, tick.telemetry)
        report = report_builder.build(watched, "x", alive, 0.0, 0.0)  # at every tick, also between the values
    last, again = (summarize(metrics, "x", "inprocess", 1.0) for metrics in (watched, alone))
    assert last == again
    assert (report.team_index, report.team_index_target) == (last["team_index"], last["team_index_target"])
    assert len(report.cutting) == last["cutting_robots"]
    assert (report.slots[9], report.plans[9]) == (-1, progress.NO_PLAN)  # it died
    assert report.plans[:9].tolist() == [0] * 9
    assert len(set(report.slots[:9].tolist())) == 9  # slots of the plan of ten, which still has the mark of robot 9
    assert set(report.slots[:9].tolist()) < set(range(10))


def test_the_index_is_that_of_the_robots_present_over_the_true_links() -> None:
    scenario = short()
    *_, last = inprocess.ticks(scenario)
    state = last.state
    links = delivery.links_of(state, scenario.objective)
    result = team_index(state.poses[state.present, :2], links, scenario.objective)
    assert result is not None
    assert links.shape == (9, 9)
    summary = inprocess.run(scenario, "x")
    assert summary["team_index"] == result.value
    assert summary["delivery_after_loss"] == result.delivery
    intact = replace(state, present=np.ones(10, dtype=np.bool_))
    assert delivery.links_of(intact, scenario.objective).shape == (10, 10)


def test_the_target_follows_the_robots_and_the_channel() -> None:
    scenario, targets = short(), []
    metrics = MetricsCollector(scenario)
    for tick in inprocess.ticks(scenario):
        metrics.add(tick.state, tick.twists, tick.telemetry)
        assert metrics.team is not None
        if tick.state.tick in (70, 80, 149):
            targets.append(metrics.team.latest.target)
    assert targets == pytest.approx([0.6894, 0.6979, targets[2]], abs=5e-5)  # the patches of ten and of nine
    assert targets[2] < 0.6


def test_a_level_is_reached_from_the_last_time_on_from_which_the_index_stays_at_it() -> None:
    scenario = load("pair.toml", run__duration=8.0, objective__team_index=True)
    series: list[tuple[int, float]] = []
    metrics = MetricsCollector(scenario)
    for tick in inprocess.ticks(scenario):
        metrics.add(tick.state, tick.twists, tick.telemetry)
        assert metrics.team is not None
        if tick.state.tick % 5 == 0:  # 0.1 s
            series.append((tick.state.tick, metrics.team.latest.team_index / metrics.team.latest.target))
    summary = summarize(metrics, "pair", "inprocess", 1.0)
    for name, share in quantities.TEAM_LEVELS.items():
        below = [tick for tick, value in series if value < share]
        assert below, name
        assert summary[name] == pytest.approx(0.02 * (below[-1] + 5))


def test_an_index_of_a_target_of_zero_reaches_no_level() -> None:
    far = load(
        "team-paper-start.toml",
        run__duration=1.0,
        formation__configuration="line",
        objective__minimum_separation=100.0,
        expect=[],
    )
    summary = inprocess.run(far, "x")
    assert summary["team_index_target"] == 0.0
    assert summary["team_index"] > 0.0
    assert [summary[key] for key in quantities.TEAM_LEVELS] == [None, None]


def test_links_that_do_not_connect_the_team_have_no_number_of_cutting_robots() -> None:
    poses = [(0.0, 0.0, 0.0), (60.0, 0.0, 0.0), (400.0, 0.0, 0.0), (460.0, 0.0, 0.0)]
    apart = load("neighborhood.toml", run__duration=0.2, objective__team_index=True, robots__poses=poses)
    assert inprocess.run(apart, "x")["cutting_robots"] is None
    dead = [{"at": 0.5, "kill": [2, 3]}]
    half = load("neighborhood.toml", run__duration=2.0, objective__team_index=True, robots__poses=poses, event=dead)
    assert inprocess.run(half, "x")["cutting_robots"] == 0


def test_a_large_team_allocates_no_matrix_of_its_links(monkeypatch: pytest.MonkeyPatch) -> None:
    crowd = load("hundred.toml", run__duration=0.04, objective__team_index=True)
    more = {"kind": "grid", "count": 144, "spacing": 60.0}
    large = load("hundred.toml", run__duration=0.04, objective__team_index=True, robots=more)
    asked: list[int] = []
    links_of = delivery.links_of

    def counted(state: Any, objective: Any) -> Any:
        asked.append(int(state.present.sum()))
        return links_of(state, objective)

    monkeypatch.setattr(delivery, "links_of", counted)
    inprocess.run(crowd, "x")
    assert set(asked) == {100}
    assert inprocess.run(large, "x")["team_index"] is None
    assert set(asked) == {100}


def test_only_runs_that_ask_for_the_team_index_have_it() -> None:
    plain = inprocess.run(load("neighborhood.toml", run__duration=0.2), "x")
    assert not set(TEAM) & set(plain)
    asked = inprocess.run(load("neighborhood.toml", run__duration=0.2, objective__team_index=True), "x")
    assert set(TEAM) <= set(asked)
    assert plain["digest"] == asked["digest"]
    assert {key: asked[key] for key in without_machine(plain)} == without_machine(plain)


def test_an_expectation_of_a_key_that_the_run_will_not_have_is_rejected() -> None:
    expected = [{"of": "team_index", "above": 0.6}]
    with pytest.raises(ScenarioError, match="'team_index' exists only where a configuration is sought"):
        load("neighborhood.toml", expect=expected)
    assert load("neighborhood.toml", objective__team_index=True, expect=expected).has_team_index
    assert load("team-paper-start.toml", expect=expected).has_team_index


def test_a_law_without_slots_has_none_in_the_report() -> None:
    scenario = load("neighborhood.toml", run__duration=0.1, objective__team_index=True)
    *_, last = inprocess.ticks(scenario)
    slots, plans = progress.places(scenario, last.telemetry)
    assert len(slots) == len(plans) == 0


def test_a_team_of_one_has_no_index() -> None:
    scenario = load("pair.toml", run__duration=1.0, objective__team_index=True, event=[{"at": 0.5, "kill": [1]}])
    summary = inprocess.run(scenario, "x")
    assert [summary[key] for key in TEAM[:2]] == [None, None]
    assert summary["cutting_robots"] == 0
    assert summary["covered_area"] == pytest.approx(math.pi * 50.0**2)
    assert [summary[key] for key in quantities.TEAM_LEVELS] == [None, None]
    assert TeamProgress(scenario).times() == dict.fromkeys(quantities.TEAM_LEVELS)
