"""Remarks: no part of a scenario is changed or ignored without one."""

from pathlib import Path
from typing import Any

import pytest

from console.backends import inprocess
from fes.model.seeking import MeasuredConfig
from fes.protocol.channel_change import ChangeResult, decode_result, encode_result
from tests.support.loop import load
from tests.support.paths import CONFIGS
from world.config import remarks
from world.execution.run import Run

MEASURED = {"seeking__index": "measured"}


@pytest.mark.parametrize("path", sorted(CONFIGS.rglob("*.toml")), ids=lambda path: path.stem)
def test_the_shipped_scenarios_run_as_written(path: Path) -> None:
    name = str(path.relative_to(CONFIGS))
    assert remarks.of(load(name)) == []


CASES: dict[str, tuple[dict[str, Any], list[str]]] = {
    "a duration that is rounded down": (
        {"run__dt": 0.3, "run__duration": 1.0, "seeking__sub_step": 0.01},
        ["run.duration 1 s is not a multiple of run.dt 0.3 s: 3 ticks are run, 0.9 s"],
    ),
    "one of less than a tick": (
        {"run__duration": 0.001},
        ["run.duration 0.001 s is not a multiple of run.dt 0.02 s: 1 ticks are run, 0.02 s"],
    ),
    "an event after the end, and one at it": (
        {"run__duration": 0.4, "event": [{"at": 99.0, "kill": [0]}, {"at": 0.4, "world_away": 1.0}]},
        ["event at 99, 0.4 s is not before the end of the run at 0.4 s: it never acts"],
    ),
    "an event between two ticks": (
        {"event": [{"at": 0.013, "kill": [0]}]},
        ["event at 0.013 s is not a multiple of run.dt 0.02 s: it acts at 0.02 s"],
    ),
    "seven of them": (
        {"event": [{"at": at + 0.005, "set": {"channel.jammers": []}} for at in range(7)]},
        [
            "event at 0.005, 1.005, 2.005, 3.005, 4.005 and 2 more s is not a multiple of run.dt 0.02 s: "
            "it acts at 0, 1, 2, 3, 4 and 2 more s"
        ],
    ),
    "a delay": (
        {"event": [{"at": 1.0, "transmitter": {"robot": 0, "delay": 0.05}}]},
        ["transmitter: delay 0.05 s is not a multiple of run.dt 0.02 s: it is rounded to 0.04 s"],
    ),
    "a channel that the robots know": (
        {"event": [{"at": 1.0, "set": {"channel.reference_snr": 5e6}}]},
        [f"the channel is set at 1 s, but {remarks.UNNOTICED}"],
    ),
    "a channel that they measure": ({**MEASURED, "event": [{"at": 1.0, "set": {"channel.reference_snr": 5e6}}]}, []),
    "a setting that they do not know": (
        {"event": [{"at": 1.0, "set": {"channel.partition": [[0], [1]]}}]},
        [],
    ),
    "the formula that they know already": ({"event": [{"at": 1.0, "set": {"channel.reference_snr": 1e7}}]}, []),
    "a decimal fraction that is not finite in binary": (
        {"run__dt": 0.1, "run__duration": 0.3, "event": [{"at": 0.2, "kill": [0]}]},
        [],
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_each_kind_of_deviation_has_its_line(case: str) -> None:
    settings, lines = CASES[case]
    assert remarks.of(load("pair.toml", **settings)) == lines


def test_the_run_agrees_with_the_lines() -> None:
    """The times of the cases above, in a run."""
    short = load("pair.toml", **CASES["a duration that is rounded down"][0])
    assert inprocess.run(short, "pair")["simulated_s"] == pytest.approx(0.9)
    moved = load("pair.toml", run__duration=0.1, event=[{"at": 0.013, "kill": [0]}])
    assert [tick.state.present[0] for tick in inprocess.ticks(moved)] == [True, False, False, False, False]
    late = load("pair.toml", run__duration=0.1, event=[{"at": 0.1, "kill": [0]}])
    assert all(tick.state.present[0] for tick in inprocess.ticks(late))


@pytest.mark.parametrize(
    ("settings", "path", "value", "unnoticed"),
    [
        ({}, "channel.reference_snr", 5e6, True),
        ({}, "channel.model", "perfect", True),
        ({}, "channel.reference_snr", 1e7, False),  # the value that they know
        ({}, "channel.jammers", [{"x": 0.0, "y": 0.0, "radius": 5.0}], False),
        (MEASURED, "channel.reference_snr", 5e6, False),
        ({"seeking__index": "sampled", "seeking__index_transform": "none"}, "channel.reference_snr", 5e6, False),
    ],
)
def test_the_result_of_a_change_tells_whether_the_robots_notice_it(
    settings: dict[str, Any], path: str, value: Any, unnoticed: bool
) -> None:
    run = Run(load("pair.toml", **settings))
    effect = run.change(path, value)
    assert effect.unnoticed is unnoticed
    assert decode_result(encode_result(effect)) == effect


def test_a_channel_that_is_set_back_is_the_one_that_the_robots_know() -> None:
    run = Run(load("pair.toml"))
    assert run.change("channel.reference_snr", 5e6).unnoticed
    assert not run.change("channel.reference_snr", 1e7).unnoticed
    assert isinstance(run.change("channel.spectral_efficiency", 2.0), ChangeResult)


def test_the_robots_of_the_scenario_in_the_remark_measure() -> None:
    assert "scenario measured-jump" in remarks.UNNOTICED
    assert isinstance(load("measured-jump.toml").seeking, MeasuredConfig)
