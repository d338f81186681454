"""Robots with noisy, slow and late poses that count beacons: the claims of docs/explanation/noise.md."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from bench.science.noise import NO_FILTER, Outcome, column, fixes, outcomes, rms
from fes.arithmetic import draws
from fes.model.sensing import Observations
from world.simulation import truth
from world.simulation.truth import State

SEEDS, FEW = range(8), range(4)


def bias(rows: Sequence[Outcome]) -> float:
    return float(column(rows, "bias").mean())


def separation(changes: dict[str, Any]) -> float:
    """Root mean square error of the separations, of two runs of 75 s [m]."""
    return rms(column(outcomes(changes, range(2), 75.0), "separation_rmse"))


def turning(rows: Sequence[Outcome]) -> float:
    """Root mean square of the angular velocities [rad/s]."""
    return math.sqrt(np.mean([outcome.turning for outcome in rows]))


@pytest.mark.slow
def test_white_noise_of_a_meter_flattens_the_fit_biases_the_estimates_and_shakes_the_team() -> None:
    rows = outcomes({"sensing.pose_noise": 1.0} | NO_FILTER, FEW, 120.0)
    assert 2.2 <= np.mean([outcome.exponent for outcome in rows]) <= 2.6  # the channel has 3
    assert bias(rows) > 0.45
    assert turning(rows) > 5.0


@pytest.mark.slow
def test_dead_reckoning_removes_what_noise_of_a_meter_and_five_degrees_does() -> None:
    exact, rows = outcomes({}, SEEDS), outcomes(fixes(1.0, 5.0), SEEDS)
    assert abs(bias(rows) - bias(exact)) <= 0.1  # the runs share the channel's draws, but not their paths
    assert abs(bias(rows)) <= 0.3
    assert rms(column(rows, "rmse")) <= 0.35
    assert rms(column(rows, "separation_rmse")) <= 0.35
    assert turning(rows) < 2.5
    assert all(outcome.connected for outcome in rows)


@pytest.mark.slow
def test_one_exact_fix_per_second_suffices_with_dead_reckoning_and_without_it_the_team_spins() -> None:
    assert separation(fixes(0.0, 0.0, 1.0)) < 0.4
    assert separation(fixes(0.0, 0.0, 1.0) | NO_FILTER) > 5.0


@pytest.mark.slow
def test_a_tenth_of_a_second_of_latency_does_no_harm_if_a_fix_corrects_the_pose_of_its_tick() -> None:
    late = fixes(0.03, 1.0, pose_latency=0.1)
    assert separation(late) < 0.4
    assert separation(late | NO_FILTER) > 5.0


@pytest.mark.slow
def test_one_fix_in_a_hundred_that_is_twenty_meters_off_does_no_harm(monkeypatch: pytest.MonkeyPatch) -> None:
    observe, key = truth.observe, draws.key(1, "outliers")

    def outlying(state: State) -> Observations:
        sensed = observe(state)
        assert sensed.fixed is not None
        robots = np.arange(len(sensed.poses))
        chance, direction = (draws.uniform_pairs(key, robots + 1000 * part, sensed.fixed) for part in (0, 1))
        way = 20.0 * (chance < 0.01)
        angle = 2.0 * math.pi * direction
        off = np.stack([way * np.cos(angle), way * np.sin(angle), 0.0 * way], axis=1)
        return replace(sensed, poses=sensed.poses + off)

    monkeypatch.setattr(truth, "observe", outlying)
    rows = outcomes(fixes(0.1, 1.0, 10.0), SEEDS)
    assert abs(bias(rows)) <= 0.3
    assert rms(column(rows, "separation_rmse")) <= 0.35
