"""The oracle's index and its parabola, over all separations that an estimate can have."""

import itertools
from typing import Literal

import numpy as np
import pytest

from agents.laws import perturbation
from agents.laws.oracle import LEAST, FormulaIndex
from agents.laws.perturbation import ESTIMATE, Seeker
from fes.arrays.types import Floats
from fes.model import objective, outage
from fes.model.config import ChannelConfig, ObjectiveConfig
from fes.model.seeking import OracleConfig

OBJECTIVES = [
    ObjectiveConfig(),
    ObjectiveConfig(minimum_separation=0.5),
    ObjectiveConfig(shape_exponent=20.0),
    ObjectiveConfig(shape_exponent=2.7),
]
CHANNELS = [
    ChannelConfig(),
    ChannelConfig(path_loss_exponent=20.0),
    ChannelConfig(model="logistic"),
    ChannelConfig(model="perfect"),
]
CASES = list(itertools.product(OBJECTIVES, CHANNELS))
FAR = np.array([1e3, 1e4, 1e6, 1e9, 1e12])


@pytest.mark.parametrize(("team", "channel"), CASES)
def test_the_index_is_the_preference_times_the_reception_at_every_separation(
    team: ObjectiveConfig, channel: ChannelConfig
) -> None:
    separation = np.concatenate([np.linspace(0.5, 200.0, 400), FAR])
    expected = objective.preference(separation, team) * outage.reception_probability(separation, channel)
    # an exponent of 700 with an error of 1e-16 of itself
    np.testing.assert_allclose(FormulaIndex(team, channel, "none")(separation), expected, rtol=1e-12, atol=1e-300)


@pytest.mark.parametrize(("team", "channel"), CASES)
@pytest.mark.parametrize("transform", ["log", "none"])
def test_slope_and_curvature_are_those_of_the_index(
    team: ObjectiveConfig, channel: ChannelConfig, transform: Literal["log", "none"]
) -> None:
    index = FormulaIndex(team, channel, transform)
    separation, step = np.linspace(20.0, 200.0, 181), 1e-3
    value, slope, bend = index.parabola(separation)
    below, center, above = index(separation - step), index(separation), index(separation + step)
    _, slope_below, _ = index.parabola(separation - step)
    _, slope_above, _ = index.parabola(separation + step)
    np.testing.assert_array_equal(value, center)
    # Central differences: errors of step^2 = 1e-6 relative, times (20 / 20 m)^2, and of 1e-16 J / step.
    size = np.maximum(np.abs(value), 1.0)
    assert (np.abs((above - below) / (2.0 * step) - slope) < 1e-5 * np.abs(slope) + 1e-12 * size).all()
    size = np.maximum(np.abs(slope), 1.0)
    assert (np.abs((slope_above - slope_below) / (4.0 * step) - bend) < 1e-5 * np.abs(bend) + 1e-12 * size).all()


@pytest.mark.parametrize(("team", "channel"), CASES)
@pytest.mark.parametrize("transform", ["log", "none"])
def test_the_parabola_is_finite_at_every_separation_and_flat_beyond_the_least_index(
    team: ObjectiveConfig, channel: ChannelConfig, transform: Literal["log", "none"]
) -> None:
    value, slope, bend = FormulaIndex(team, channel, transform).parabola(np.array([-1e12, 0.0, 1e-9, 1.0, *FAR]))
    assert np.isfinite([value, slope, bend]).all()
    assert (value >= LEAST).all()
    flat = value == LEAST if transform == "log" else value == 0.0
    assert (slope[flat] == 0.0).all()
    assert (bend[flat] == 0.0).all()


@pytest.mark.parametrize("heard", FAR)
@pytest.mark.parametrize("transform", ["log", "none"])
def test_a_peer_whose_estimate_is_far_off_leaves_the_state_finite(
    transform: Literal["log", "none"], heard: float
) -> None:
    seeker = Seeker(
        OracleConfig(index_transform=transform), FormulaIndex(ObjectiveConfig(), ChannelConfig(), transform), 0.02
    )
    state = perturbation.begin(seeker, 0, np.array([0.01, 60.0, 300.0]))
    for tick in range(300):
        state = perturbation.advance(seeker, tick, state, np.full(3, heard))
    assert np.isfinite(state).all()
    assert (np.abs(state[ESTIMATE]) < 1e14).all()


@pytest.mark.parametrize("width", [0.3, 1.0, 3.0, 12.0])
def test_a_tick_follows_the_index_where_a_narrow_channel_bends_it(width: float) -> None:
    channel = ChannelConfig(model="logistic", logistic_width=width)
    start = np.linspace(60.0, 130.0, 15)

    def ends(sub_step: float) -> Floats:
        config = OracleConfig(index_transform="none", index_gain=44460.0, sub_step=sub_step)
        seeker = Seeker(config, FormulaIndex(ObjectiveConfig(), channel, "none"), 0.02)
        state = perturbation.begin(seeker, 0, start)
        for tick in range(50):
            state = perturbation.advance(seeker, tick, state, np.full(len(start), np.nan))
        estimates: Floats = state[ESTIMATE]
        return estimates

    # Three sweeps that evaluate the index anew are off by 0.23, 0.012, 0.0013 and 0.00003 m.
    assert np.abs(ends(0.02) - ends(0.001)).max() < {0.3: 0.03, 1.0: 0.003, 3.0: 5e-4, 12.0: 1e-6}[width]
