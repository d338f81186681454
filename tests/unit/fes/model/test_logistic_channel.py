"""The logistic channel, which no exponent of (3) gives, against hand algebra, scipy and counted beacons."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.laws import oracle
from fes.model import objective, outage
from fes.model.config import ChannelConfig, ObjectiveConfig
from fes.model.sensing import DECODED
from tests.support import reference as witness
from world.config.scenario import parse
from world.metrics import optimum
from world.simulation import truth

LOGISTIC = ChannelConfig(model="logistic")
NEAR, FAR = ObjectiveConfig(minimum_separation=50.0), ObjectiveConfig(minimum_separation=100.0)

channels = st.builds(
    ChannelConfig,
    model=st.just("logistic"),
    logistic_midpoint=st.floats(30.0, 300.0),
    logistic_width=st.floats(0.5, 60.0),
)
objectives = st.builds(
    ObjectiveConfig,
    minimum_separation=st.floats(20.0, 90.0),
    maximum_separation=st.floats(130.0, 300.0),
    shape_exponent=st.floats(1.5, 6.0),
)


def log_index(r: float, team_objective: ObjectiveConfig, channel: ChannelConfig) -> float:
    """ln J of (16) with the logistic p, as plain scalars."""
    preference = witness.preference(
        r, team_objective.minimum_separation, team_objective.maximum_separation, team_objective.shape_exponent
    ).real
    return math.log(preference) - math.log1p(math.exp((r - channel.logistic_midpoint) / channel.logistic_width))


@pytest.mark.parametrize(
    ("separation", "odds"), [(100.0, 1.0), (112.0, math.e), (76.0, math.exp(-2.0)), (160.0, math.exp(5.0))]
)
def test_reception_and_outage_are_those_of_the_odds(separation: float, odds: float) -> None:
    r = np.array(separation)  # odds of a loss e^((r - 100)/12)
    assert float(outage.reception_probability(r, LOGISTIC)) == pytest.approx(1.0 / (1.0 + odds), rel=1e-14)
    assert float(outage.outage_probability(r, LOGISTIC)) == pytest.approx(odds / (1.0 + odds), rel=1e-14)


def test_far_from_the_midpoint_nothing_overflows_and_the_small_side_keeps_its_digits() -> None:
    steep = ChannelConfig(model="logistic", logistic_width=0.1)
    near, far = np.array([40.0]), np.array([160.0])  # e^-600 and e^600
    assert outage.outage_probability(near, steep)[0] == pytest.approx(math.exp(-600.0), rel=1e-12)  # 600 roundings
    assert outage.reception_probability(far, steep)[0] == pytest.approx(math.exp(-600.0), rel=1e-12)
    assert outage.reception_probability(np.array([1e9]), steep).tolist() == [0.0]


@given(channel=channels, probability=st.floats(1e-6, 1.0 - 1e-6))
def test_range_at_outage_equals_the_root_of_a_root_finder(channel: ChannelConfig, probability: float) -> None:
    def excess(r: float) -> float:
        return math.tanh(0.5 * (r - channel.logistic_midpoint) / channel.logistic_width) - (2.0 * probability - 1.0)

    if excess(0.0) >= 0.0:
        with pytest.raises(ValueError, match="larger outage at every separation"):
            outage.range_at_outage(probability, channel)
        return
    result = outage.range_at_outage(probability, channel)
    # tanh near 1 knows 1 - outage >= 1e-6 to 1e-16, so r to 1e-10 widths
    assert result == pytest.approx(witness.root(excess, 0.0, 2000.0), abs=1e-9 * channel.logistic_width + 1e-10)


@given(channel=channels, separation=st.floats(1.0, 300.0))
def test_the_slope_of_ln_p_is_its_derivative(channel: ChannelConfig, separation: float) -> None:
    z = (separation - channel.logistic_midpoint) / channel.logistic_width
    # by hand from p = 1/(1 + e^z): p'/p = -e^z/(1 + e^z)/w, written so that e^-600 does not overflow
    expected = -1.0 / (1.0 + math.exp(-z)) / channel.logistic_width if z > -700 else 0.0
    result = float(outage.log_reception_slope(np.array([separation]), channel)[0])
    assert result == pytest.approx(expected, rel=1e-12, abs=1e-300)


@pytest.mark.parametrize("channel", [ChannelConfig(), LOGISTIC, ChannelConfig(model="perfect")])
def test_the_slope_of_ln_p_is_that_of_differences_for_every_model(channel: ChannelConfig) -> None:
    r, h = np.linspace(5.0, 200.0, 40), 1e-3  # m; h^2 (ln p)'''/6 = 1e-11, roundings 1e-16/h
    ahead, behind = (np.log(outage.reception_probability(r + step, channel)) for step in (h, -h))
    np.testing.assert_allclose(outage.log_reception_slope(r, channel), (ahead - behind) / (2.0 * h), atol=1e-11)


@given(team_objective=objectives, channel=channels)
def test_no_separation_is_better_than_the_optimum(team_objective: ObjectiveConfig, channel: ChannelConfig) -> None:
    best = optimum.optimal_separation(team_objective, channel)
    expected = witness.maximizer(
        lambda r: log_index(r, team_objective, channel),
        1.0,
        team_objective.maximum_separation,
    )
    # a maximum read off values is known to sqrt(2e-16 |ln J|/(ln J)'') = 1e-7 of r or so
    assert best == pytest.approx(expected, rel=2e-6)


@pytest.mark.parametrize("team_objective", [NEAR, FAR])
def test_the_oracles_index_is_preference_times_logistic_reception(team_objective: ObjectiveConfig) -> None:
    r = np.linspace(5.0, 250.0, 50)
    expected = objective.preference(r, team_objective) / (1.0 + np.exp((r - 100.0) / 12.0))
    np.testing.assert_allclose(
        oracle.FormulaIndex(team_objective, LOGISTIC, "none")(r), expected, rtol=1e-12
    )  # roundings
    np.testing.assert_allclose(
        oracle.FormulaIndex(team_objective, LOGISTIC, "log")(r), np.log(expected), rtol=1e-12, atol=1e-13
    )


def test_a_logistic_channel_has_no_scale_of_equation_3() -> None:
    with pytest.raises(ValueError, match="not of the form"):
        outage.exponent_scale(LOGISTIC)


def test_beacons_decode_with_the_probability_of_the_logistic_channel() -> None:
    poses = [[0.0, 0.0, 0.0], [90.0, 0.0, 0.0], [0.0, 110.0, 0.0]]  # the third pair, 142 m, decodes 3 %
    world = truth.create(parse({"schema": 1, "robots": {"poses": poses}, "channel": {"model": "logistic"}}, ""))
    state, ticks = truth.start(world), 4000
    heard = np.zeros(6)
    for _ in range(ticks):
        state = truth.step(world, state, np.zeros((3, 2)))
        heard += truth.observe(state).reception == DECODED
    edges = state.radio.edges
    where = np.array(poses)
    separation = np.hypot(*(where[edges.rows, :2] - where[edges.peers, :2]).T)
    p = 1.0 / (1.0 + np.exp((separation - 100.0) / 12.0))
    sent = ticks - 1  # contacts open at tick 2
    assert (abs(heard / sent - p) < 4.0 * np.sqrt(p * (1.0 - p) / sent)).all()  # 4 sigma, binomial
