"""Changes of a running run: scheduled in the scenario, or requested from another terminal."""

import asyncio
import datetime
from typing import Any

import pytest

from console.backends import inprocess
from fes.errors import MessageError, Rejected, ScenarioError
from fes.protocol import channel_change, keys, wire
from fes.protocol.channel_change import ParameterChange
from tests.support import session
from tests.support.loop import load
from tests.support.processes import PATIENCE
from world.config import events
from world.config.events import EventConfig
from world.config.radio import RadioConfig
from world.simulation import truth

HALVED = {"at": 0.2, "set": {"channel.reference_snr": 5e6}}


def test_an_event_acts_from_its_tick_on_and_the_optimum_moves_with_it() -> None:
    scenario = load("pair.toml", run__duration=1, event=[HALVED])
    seen = [(tick.state.tick, tick.state.channel.reference_snr) for tick in inprocess.ticks(scenario)]
    assert [snr for _, snr in seen] == [1e7] * 10 + [5e6] * 40
    summary = inprocess.run(scenario, "pair")
    assert [row["at"] for row in summary["tracking"]] == [0.0, 0.2]
    assert [row["optimal_separation"] for row in summary["tracking"]] == pytest.approx([68.114, 65.524], abs=1e-3)
    assert summary["optimal_separation"] == summary["tracking"][-1]["optimal_separation"]


def test_an_event_at_tick_0_equals_a_scenario_with_that_setting() -> None:
    begun = load("pair.toml", run__duration=1, channel__reference_snr=5e6)
    changed = load("pair.toml", run__duration=1, event=[{**HALVED, "at": 0.0}])
    world = truth.create(changed)
    assert truth.start(world).channel == begun.channel


def test_the_later_of_two_events_of_one_tick_wins_and_other_events_act_in_order_of_time() -> None:
    def event(at: float, path: str, value: Any) -> EventConfig:
        return EventConfig.model_validate({"at": at, "set": {path: value}})

    snr, exponent = "channel.reference_snr", "channel.path_loss_exponent"
    result = events.schedule([event(2.0, snr, 1.0), event(1.0, snr, 2.0), event(1.004, exponent, 2.5)], 0.02)
    assert list(result.items()) == [(50, {snr: 2.0, exponent: 2.5}), (100, {snr: 1.0})]
    assert events.schedule([event(1.0, snr, 1.0), event(1.0, snr, 2.0)], 0.02) == {50: {snr: 2.0}}
    table, part = "channel.shadowing", "channel.shadowing.deviation"
    [again] = events.schedule([event(1.0, part, 6.0), event(1.0, table, {}), event(1.0, part, 6.0)], 0.02).values()
    assert list(again) == [table, part]  # the last value, not the first


@pytest.mark.parametrize(
    ("settings", "path", "value"),
    [
        ({"channel.reference_snr": 5e6}, "channel.reference_snr", 5e6),
        ({"channel.shadowing.deviation": 8}, "channel.shadowing.decorrelation_distance", 20.0),
        ({"channel.communication_range": 80}, "channel.communication_range", 80.0),
        (
            {"channel.jammers": [{"x": 1.0, "y": 2.0, "radius": 3.0}]},
            "channel.jammers",
            [{"x": 1.0, "y": 2.0, "radius": 3.0, "reception_factor": 0.0}],
        ),
    ],
)
def test_the_summary_has_the_effective_value_of_a_setting(settings: dict[str, Any], path: str, value: Any) -> None:
    assert events.effective(events.changed(RadioConfig(), settings, 0.02), path) == value


@pytest.mark.parametrize(
    ("settings", "rule"),
    [
        ({"formation.rule": "disk"}, "only fields like 'channel.reference_snr' can change during a run"),
        (
            {"channel.reference_srn": 1.0},
            "unknown field 'channel.reference_srn'; did you mean 'channel.reference_snr'?",
        ),
        ({"channel.reference_snr": -1.0}, "channel.reference_snr: must be greater than 0, got -1.0"),
        ({"channel.reference_snr": "much"}, "must be a valid number, got 'much'"),
        ({"channel.reference_snr.much": 1.0}, "goes through 'reference_snr', which is not a table"),
        ({"channel.bursts": {"bad_share": 0.5, "mean_length": 0.001}}, "mean_length must be at least run.dt"),
        ({"channel.shadowing": None}, "cannot be null"),
        ({"channel.": 1.0}, "unknown field 'channel'"),
    ],
)
def test_an_impossible_change_is_rejected_in_one_line_whether_requested_or_scheduled(
    settings: dict[str, Any], rule: str
) -> None:
    with pytest.raises(ScenarioError) as asked:
        events.changed(RadioConfig(), settings, 0.02)
    assert rule in str(asked.value)
    with pytest.raises(ScenarioError) as scheduled:
        load("pair.toml", event=[{"at": 1.0, "set": settings}])
    assert rule in str(scheduled.value)
    assert "\n" not in str(scheduled.value)


def test_a_run_changed_by_fes_set_can_be_repeated_from_its_recorded_changes() -> None:
    scenario = load("pair.toml", run__duration=8)
    answers: list[Any] = []

    async def disturb(endpoint: str, begin: asyncio.Event) -> None:
        async with session.client(endpoint) as terminal:
            begin.set()

            async def ask(path: str, value: Any) -> Any:
                query = channel_change.encode_change(ParameterChange(path, value))
                return channel_change.decode_result(await terminal.get(keys.change(session.RUN), query, PATIENCE))

            answers.append(await ask("channel.reference_snr", 5e6))
            with pytest.raises(Rejected, match="must be greater than 0, got -5"):
                await ask("channel.reference_snr", -5)
            with pytest.raises(Rejected, match="only fields like"):
                await ask("seeking.law", "paper")
            jammers = [{"x": float(index), "y": 0.0, "radius": 1.0} for index in range(100)]
            answers.append(await ask("channel.jammers", jammers))
            with pytest.raises(Rejected, match="expects 2 fields"):
                await terminal.get(keys.change(session.RUN), wire.pack("x"), PATIENCE)

    summary, server, _ = asyncio.run(session.run(scenario, [[0], [1]], disturb))
    effect, [*jammers] = answers[0], answers[1].value
    assert [disc["x"] for disc in jammers] == list(range(100))
    assert (effect.path, effect.value) == ("channel.reference_snr", 5e6)
    assert effect.optimal_separation == pytest.approx(65.524, abs=1e-3)
    event = server.run.scenario.event[0]
    assert event.at == pytest.approx(effect.tick * 0.02)
    assert event.settings == {"channel.reference_snr": 5e6}
    again = inprocess.run(server.run.scenario, "pair")
    assert again["digest"] == summary["digest"] != inprocess.run(scenario, "pair")["digest"]
    assert again["tracking"] == summary["tracking"]


def test_a_change_that_would_invalidate_a_scheduled_event_is_rejected_and_the_run_continues() -> None:
    bursts = {"bad_share": 0.1, "mean_length": 1.0, "loss": 0.5}
    later = {"at": 3.0, "set": {"channel.bursts.bad_share": 0.9}}
    scenario = load("pair.toml", run__duration=4.0, channel__bursts=bursts, event=[later])
    short = ParameterChange("channel.bursts.mean_length", 0.1)
    events.changed(scenario.channel, {short.path: short.value}, scenario.run.dt)  # now the event is valid

    async def disturb(endpoint: str, begin: asyncio.Event) -> None:
        async with session.client(endpoint) as terminal:
            with pytest.raises(Rejected, match=r"^channel\.bursts\.mean_length, with the scheduled events: event"):
                await terminal.get(keys.change(session.RUN), channel_change.encode_change(short), PATIENCE)

    summary, server, _ = asyncio.run(session.run(scenario, [[0], [1]], disturb))
    assert summary["ticks"] == scenario.ticks
    assert server.run.scenario == scenario


def test_a_value_that_no_message_can_carry_is_reported_in_one_line() -> None:
    with pytest.raises(MessageError, match="expects finite numbers, words, lists or tables"):
        channel_change.encode_change(ParameterChange("channel.reference_snr", datetime.date(2020, 1, 1)))


def test_an_event_that_changes_nothing_starts_no_segment() -> None:
    same = {"at": 0.2, "set": {"channel.reference_snr": 1e7}}
    assert len(inprocess.run(load("pair.toml", run__duration=1, event=[same]), "pair")["tracking"]) == 1


@pytest.mark.parametrize("payload", [b"", b"\xc0", wire.pack("a", "{"), wire.pack("", "1")])
def test_an_invalid_change_is_a_message_error(payload: bytes) -> None:
    with pytest.raises(MessageError):
        channel_change.decode_change(payload)
