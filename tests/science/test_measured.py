"""Robots find the optimum by counting beacons: no agent evaluates or receives the channel."""

import math
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from agents.control import clocks
from console.backends import inprocess, stacked
from fes.extension.context import SeededDraws
from tests.support.loop import load
from tests.support.paths import CONFIGS
from world.config.scenario import agent_config

SAMPLED = {
    "seeking__index": "sampled",
    "seeking__index_transform": "none",
    "seeking__index_gain": 44460.0,
    "seeking__dither_amplitude": 0.2,
    "seeking__dither_frequency": 100.0,
}
"""The paper's (18) with its dither and gain, fed with samples that a radio can measure."""


def tracked(name: str, seeds: range, segment: int = 0, **changes: Any) -> dict[str, list[Any]]:
    """Tracking of runs over seeds in one segment, column by column."""
    summaries = stacked.run([load(name, run__seed=seed, **changes) for seed in seeds], name)
    rows = [{**summary["tracking"][segment], "connected": summary["links_connected_always"]} for summary in summaries]
    return {key: [row[key] for row in rows] for key in rows[0]}


def median(times: list[float | None]) -> float:
    return float(np.median([math.inf if time is None else time for time in times]))


def rms(values: list[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


@pytest.mark.slow
def test_counting_beacons_finds_the_optimum() -> None:
    tracking = tracked("measured.toml", range(10))
    assert median(tracking["time_to_1m"]) <= 12.0
    assert abs(np.mean(tracking["bias"])) <= 0.2
    assert rms(tracking["rmse"]) <= 0.35
    assert rms(tracking["separation_rmse"]) <= 0.35
    assert max(tracking["disagreement_max"]) < 0.5
    assert all(tracking["connected"])


@pytest.mark.slow
def test_counting_beacons_finds_the_farther_optimum_of_a_team_that_prefers_to_spread() -> None:
    tracking = tracked("measured-coverage.toml", range(8))
    assert median(tracking["time_to_1m"]) <= 17.0
    assert rms(tracking["rmse"]) <= 0.5
    assert abs(np.mean(tracking["bias"])) <= 0.5


def test_robots_follow_a_channel_that_changes_without_notice() -> None:
    halved = {"at": 60.0, "set": {"channel.reference_snr": 5e6}}
    tracking = tracked("measured-jump.toml", range(8), 1, event=[halved], run__duration=85)
    assert tracking["optimal_separation"] == pytest.approx([65.524] * 8, abs=1e-3)  # m; the study's figure
    assert median(tracking["time_to_1m"]) <= 10.0


@pytest.mark.slow
def test_a_channel_outside_the_family_of_the_fit_biases_estimates_by_less_than_a_fifth_of_a_meter() -> None:
    tracking = tracked("measured.toml", range(8), channel__model="logistic")
    assert abs(np.mean(tracking["bias"])) <= 0.2
    assert rms(tracking["rmse"]) <= 0.35


@pytest.mark.slow
def test_clocks_that_are_fifty_milliseconds_off_do_no_harm() -> None:
    plain, skewed = (load("measured.toml", run__duration=2, run__clock_skew=skew) for skew in (0.0, 0.05))
    config = agent_config(skewed)
    ahead = clocks.of(config, np.arange(10), SeededDraws(config.seed)).initial
    assert len(set(ahead.tolist())) == 10
    assert 0.02 < np.abs(ahead).max() <= 0.05
    assert inprocess.run(plain, "on time")["digest"] != inprocess.run(skewed, "off")["digest"]
    tracking = tracked("measured.toml", range(8), run__clock_skew=0.05)
    assert median(tracking["time_to_1m"]) <= 12.0
    assert abs(np.mean(tracking["bias"])) <= 0.2
    assert rms(tracking["rmse"]) <= 0.35
    assert max(tracking["disagreement_max"]) < 0.5


def test_teams_that_prefer_twice_the_separation_find_their_optimum_too() -> None:
    """A world scaled by two: every length, and the reference SNR by 2^3."""
    doubled: dict[str, Any] = {
        "objective__minimum_separation": 100.0,
        "objective__maximum_separation": 300.0,
        "channel__communication_range": 300.0,
        "channel__reference_snr": 8e7,
        "seeking__reference_separation": 150.0,
        "seeking__dither_amplitude": 10.0,
        "seeking__initial_estimate": [160.0, 200.0],
        "robots__poses": [[2.0 * x, 2.0 * y, heading] for x, y, heading in load("measured.toml").robots.poses or []],
    }
    tracking = tracked("measured.toml", range(4), run__duration=80, **doubled)
    assert tracking["optimal_separation"] == pytest.approx([2.0 * 68.11376] * 4, abs=1e-4)
    assert rms(tracking["rmse"]) <= 2.0 * 0.35


@pytest.mark.parametrize("gain", [1.0, 44460.0])
def test_the_papers_own_law_fed_with_samples_does_not_converge(gain: float) -> None:
    changes: dict[str, Any] = SAMPLED | {"seeking__law": "paper", "seeking__index_gain": gain}
    tracking = tracked("measured.toml", range(2), run__duration=80, **changes)
    assert tracking["time_to_1m"] == [None] * 2
    assert min(tracking["rmse"]) > 5.0


def test_agent_processes_of_a_measured_run_never_load_the_formula_nor_the_oracle(tmp_path: Path) -> None:
    """Python itself lists what each process imports; a run with the oracle shows that the list is complete."""
    loaded = {}
    for name in ("measured", "paper"):
        out = tmp_path / name
        words = ["run", str(CONFIGS / f"{name}.toml"), "--duration", "0.2", "--headless", "--out", str(out)]
        subprocess.run(
            [sys.executable, "-c", "from console.cli import main; main()", *words],
            env={**os.environ, "PYTHONVERBOSE": "1"},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=100,
            check=True,
        )
        logs = sorted(out.glob("agent*.log"))
        assert len(logs) == 10
        loaded[name] = [set(re.findall(r"^import '([\w.]+)' #", log.read_text(), re.MULTILINE)) for log in logs]
    for modules in loaded["measured"]:
        assert "agents.laws.packet_counting" in modules
        assert not {"agents.laws.oracle", "fes.model.outage"} & modules
    for modules in loaded["paper"]:
        assert {"agents.laws.oracle", "fes.model.outage"} <= modules
