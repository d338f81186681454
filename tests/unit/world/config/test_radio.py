"""Jammed discs, and the channel as an oracle, a report, a file and an error message show it."""

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fes.errors import ScenarioError
from fes.model.config import ChannelConfig
from fes.model.sensing import CLOSED, DECODED, LOST, Telemetry
from tests.support import layouts
from tests.support.radios import EVERYTHING, Pair, ledger, stand, started, team
from world.config import events, scenario
from world.config.radio import RadioConfig
from world.config.scenario import Scenario
from world.metrics import report_builder, summary
from world.metrics.collector import MetricsCollector
from world.simulation import truth
from world.simulation.truth import State


def test_receivers_in_a_jammed_disc_decode_no_beacon_and_are_heard_outside() -> None:
    # robots 0 and 1 are in the disc, 1 exactly on its edge; 2 and 3 are outside
    jam = {"x": 0.0, "y": 0.0, "radius": 50.0}
    world, state = started(team([(10, 0), (0, 50), (0, 50.01), (80, 0)], model="perfect", jammers=[jam]))
    state = stand(world, state, 200)
    for (receiver, _), decoded in ledger(state, "decoded").items():
        assert decoded == (0 if receiver in (0, 1) else 199)
    assert set(ledger(state, "sent").values()) == {199}


def test_a_disc_multiplies_the_reception_by_its_factor_and_discs_multiply() -> None:
    jams = [
        {"x": 0.0, "y": 0.0, "radius": 20.0, "reception_factor": 0.6},
        {"x": 15.0, "y": 0.0, "radius": 20.0, "reception_factor": 0.5},
    ]
    world, state = started(team([(-10, 0), (10, 0), (100, 0)], jammers=jams))
    ticks = 6000
    state = stand(world, state, ticks)
    factor = {0: 0.6, 1: 0.6 * 0.5, 2: 1.0}
    where = {0: -10.0, 1: 10.0, 2: 100.0}
    result = ledger(state, "probability")
    for (receiver, sender), decoded in ledger(state, "decoded").items():
        p = math.exp(-3e-7 * abs(where[receiver] - where[sender]) ** 3) * factor[receiver]
        assert result[receiver, sender] == pytest.approx(p, rel=1e-13)  # roundings
        sigma = math.sqrt(p * (1.0 - p) / (ticks - 1))
        assert decoded / (ticks - 1) == pytest.approx(p, abs=4.0 * sigma)  # binomial


def test_a_robot_is_jammed_where_it_is_at_the_tick_of_the_beacon() -> None:
    # robot 0 drives through the disc at 1 m per tick: inside from -2 m to 2 m, at ticks 3 to 7
    jam = {"x": 0.0, "y": 0.0, "radius": 2.0}
    world, state = started(team([(-5, 0), (0, 60)], model="perfect", jammers=[jam]))
    reports = []
    for _ in range(12):
        state = truth.step(world, state, np.array([[50.0, 0.0], [0.0, 0.0]]))
        reports.append(ledger(state, "reception")[0, 1])
    # tick + 1 reports beacons of tick, so LOST is reported at ticks 4 to 8
    assert reports == [CLOSED, DECODED, DECODED, *[LOST] * 5, *[DECODED] * 4]


def report_outage(state: State, what: Scenario, pairs: list[Pair]) -> list[float]:
    """Outage in the report, of links (a, b), a < b, that both robots use."""
    links = layouts.edges(range(len(state.poses)), [*pairs, *((b, a) for a, b in pairs)])
    none = np.zeros((2, 0)), np.zeros((len(state.poses), 0))
    metrics, telemetry = MetricsCollector(what), Telemetry(links, np.full(len(links), 70.0), *none)
    metrics.add(state, np.zeros((len(state.poses), 2)), telemetry)
    report = report_builder.build(metrics, "test", np.ones(len(state.poses), dtype=np.uint8), 1.0, 1.0)
    assert list(zip(report.a.tolist(), report.b.tolist(), strict=True)) == pairs
    return [float(outage) for outage in report.outage]


def test_a_report_shows_the_true_outage_both_ways_averaged() -> None:
    jam = {"x": 0.0, "y": 0.0, "radius": 10.0, "reception_factor": 0.25}
    bursts = {"bad_share": 0.2, "mean_length": 1.0, "loss": 0.5}
    configured = team([(0, 0), (60, 0), (140, 0), (160, 0)], jammers=[jam], bursts=bursts)
    world, state = started(configured)

    def p(r: float) -> float:
        return math.exp(-3e-7 * r**3) * 0.9

    before = [1.0 - p(60.0), 1.0 - p(160.0), 1.0 - p(80.0)]  # no beacon was sent: the formula
    assert report_outage(state, configured, [(0, 1), (0, 3), (1, 2)]) == pytest.approx(before, rel=1e-12)  # roundings
    # robot 0 is jammed; robots 0 and 3 are out of range: still the formula
    after = [1.0 - p(60.0) * (0.25 + 1.0) / 2.0, 1.0 - p(160.0), 1.0 - p(80.0)]
    result = report_outage(stand(world, state), configured, [(0, 1), (0, 3), (1, 2)])
    assert result == pytest.approx(after, rel=1e-12)


def test_a_report_shows_the_outage_of_a_shadowed_link() -> None:
    configured = team([(0, 0), (60, 0), (100, 30)], shadowing={"deviation": 8.0})
    world, state = started(configured)
    state = stand(world, state)
    p = ledger(state, "probability")
    result = report_outage(state, configured, [(0, 1), (0, 2), (1, 2)])
    assert result == pytest.approx([1.0 - p[0, 1], 1.0 - p[0, 2], 1.0 - p[1, 2]], rel=1e-12)
    plain = 1.0 - np.exp(-3e-7 * np.array([60.0, math.hypot(100, 30), 50.0]) ** 3)
    assert (abs(result - plain) > 1e-3).all()


def test_an_oracle_receives_the_formula_without_the_effects_on_top_of_it() -> None:
    configured = team([(0, 0), (60, 0)], **EVERYTHING)
    config = scenario.agent_config(configured).channel
    assert type(config) is ChannelConfig
    assert config == ChannelConfig(model="logistic", logistic_midpoint=90.0)


def test_the_channel_of_a_run_directory_is_the_one_that_was_run(tmp_path: Path) -> None:
    for channel in (EVERYTHING, {"jammers": EVERYTHING["jammers"]}, {"bursts": EVERYTHING["bursts"]}, {}):
        ran = team([(0, 0), (60, 0)], **channel)
        summary.write_scenario(tmp_path, ran)
        again = scenario.load(tmp_path / "scenario.toml")
        assert again == ran
        assert again.channel == RadioConfig.model_validate(channel)


JAMMER = {"x": 0.0, "y": 0.0, "radius": 1.0}
UNKNOWN = "unknown field 'channel.{}'; did you mean 'channel.{}'?"


@pytest.mark.parametrize(
    ("channel", "message"),
    [
        ({"shadowing": {}}, "channel.shadowing.deviation: is required"),
        (
            {"shadowing": {"deviation": -1.0}},
            "channel.shadowing.deviation: must be greater than or equal to 0, got -1.0",
        ),
        ({"shadowing": {"deviaton": 6.0}}, UNKNOWN.format("shadowing.deviaton", "shadowing.deviation")),
        ({"burst": {}}, UNKNOWN.format("burst", "bursts")),
        ({"bursts": {"bad_shar": 0.5}}, UNKNOWN.format("bursts.bad_shar", "bursts.bad_share")),
        ({"jammers": [{"radus": 1.0}]}, UNKNOWN.format("jammers.0.radus", "jammers.radius")),
        ({"jammers": [{**JAMMER, "radius": 0.0}]}, "channel.jammers.0.radius: must be greater than 0, got 0.0"),
        ({"jammers": [JAMMER, {**JAMMER, "x": math.nan}]}, "channel.jammers.1.x: must be a finite number, got nan"),
        (
            {"jammers": [{**JAMMER, "reception_factor": 1.5}]},
            "channel.jammers.0.reception_factor: must be less than or equal to 1, got 1.5",
        ),
        ({"logistic_width": 0.0}, "channel.logistic_width: must be greater than or equal to 0.001, got 0.0"),
        (
            {"model": "rician"},
            "channel.model: there is no channel 'rician'; "
            "known are rayleigh, logistic, perfect, table, trace, and `module:Class`",
        ),
        ({"model": "raleigh"}, "channel.model: there is no channel 'raleigh'; did you mean 'rayleigh'?"),
    ],
)
def test_an_impossible_channel_is_rejected_in_one_line(channel: dict[str, Any], message: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        team([(0, 0)], **channel)
    assert str(caught.value) == f"here: {message}"


@pytest.mark.parametrize(
    ("model", "given"),
    [
        ({"use": "rayleigh", "reference_snr": 1e6}, "reference_snr"),
        ({"use": "table", "rows": [[0.0, 1.0], [9.0, 0.0]]}, "rows"),
        ({"use": "trace", "gain": 1.0}, "gain"),
    ],
)
def test_a_built_in_model_takes_no_parameters_that_would_have_no_effect(model: dict[str, Any], given: str) -> None:
    expected = f"channel: model: '{model['use']}' takes its settings from [channel] itself, got '{given}'"
    with pytest.raises(ScenarioError, match=re.escape(expected)):
        team([(0, 0), (60, 0)], model=model)
    with pytest.raises(ScenarioError, match=re.escape(expected.removeprefix("channel: "))):
        events.changed(RadioConfig(), {"channel.model": model}, 0.02)


def test_a_built_in_model_in_a_table_of_its_own_is_that_model() -> None:
    rows = [(0.0, 1.0), (90.0, 0.5)]
    with pytest.raises(ScenarioError, match="rows: model 'table' needs at least two, got 0"):
        events.changed(RadioConfig(), {"channel.model": {"use": "table"}}, 0.02)
    settings = {"channel.model.use": "table", "channel.rows": rows}
    assert events.changed(RadioConfig(), settings, 0.02) == RadioConfig(model="table", rows=rows)
    assert events.effective(RadioConfig(model="logistic"), "channel.model.use") == "logistic"
