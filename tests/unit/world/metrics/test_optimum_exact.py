"""r* over all settings that a scenario may have, against mpmath: the nearest float, equal on every machine."""

import math
from pathlib import Path
from typing import Any

import mpmath
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from console.backends import inprocess
from fes.model.config import ChannelConfig, ObjectiveConfig
from fes.protocol.report import Report
from tests.support.examples import EXAMPLES
from tests.support.loop import load
from world.execution.run import Run
from world.metrics.optimum import optimal_separation

SMALLEST, LARGEST = 5e-324, 1.7e308


def anywhere(low: float = 1e-300, high: float = 1e300) -> st.SearchStrategy[float]:
    """Numbers from `low` to `high`, all decades equally likely."""
    return st.floats(math.log10(low), math.log10(high)).map(lambda power: min(max(10.0**power, low), high))


objectives = st.lists(anywhere(), min_size=2, max_size=2, unique=True).flatmap(
    lambda bounds: st.builds(
        ObjectiveConfig,
        minimum_separation=st.just(min(bounds)),
        maximum_separation=st.just(max(bounds)),
        shape_exponent=anywhere(1e-3, 20.0),
    )
)
channels = st.builds(
    ChannelConfig,
    model=st.sampled_from(["rayleigh", "logistic", "perfect"]),
    reference_snr=anywhere(),
    spectral_efficiency=anywhere(1e-300, 100.0),
    path_loss_exponent=anywhere(1e-3, 20.0),
    reference_distance=anywhere(1e-6, 1e6),
    logistic_midpoint=anywhere(),
    logistic_width=anywhere(1e-3, 1e6),
)


def rises(r: float, team_objective: ObjectiveConfig, channel: ChannelConfig) -> bool:
    """True if ln J of (16) rises at r: r (ln J)' by hand, in 60 digits."""
    with mpmath.workdps(60):
        x, shape = mpmath.mpf(r), mpmath.mpf(team_objective.shape_exponent)
        spread = (x / team_objective.minimum_separation) ** shape
        reach = (x / team_objective.maximum_separation) ** shape
        vector = shape * spread * (mpmath.exp(-spread) / -mpmath.expm1(-spread))
        loss = mpmath.mpf(0)
        if channel.model == "logistic":
            loss = x / channel.logistic_width
            loss /= 1 + mpmath.exp((channel.logistic_midpoint - x) / mpmath.mpf(channel.logistic_width))
        if channel.model == "rayleigh":
            exponent = mpmath.mpf(channel.path_loss_exponent)
            threshold = mpmath.expm1(channel.spectral_efficiency * mpmath.log(2))
            loss = exponent * threshold / channel.reference_snr * (x / channel.reference_distance) ** exponent
        return bool(vector > shape * reach + loss)


@settings(max_examples=3 * EXAMPLES // 2)
@given(team_objective=objectives, channel=channels)
@example(team_objective=ObjectiveConfig(), channel=ChannelConfig())
@example(team_objective=ObjectiveConfig(maximum_separation=LARGEST), channel=ChannelConfig(model="perfect"))
@example(team_objective=ObjectiveConfig(), channel=ChannelConfig(reference_snr=SMALLEST))
def test_the_index_rises_below_the_optimum_and_falls_above_it(
    team_objective: ObjectiveConfig, channel: ChannelConfig
) -> None:
    best = optimal_separation(team_objective, channel)
    below, above = math.nextafter(best, 0.0), math.nextafter(best, math.inf)
    assert below == 0.0 or rises(below, team_objective, channel)
    assert not rises(above, team_objective, channel)


@settings(max_examples=30)
@given(minimum=anywhere(1e-3, 1e3), snr=anywhere(1e3, 1e9), farther=anywhere(1e13, LARGEST))
def test_the_optimum_does_not_depend_on_a_maximum_separation_far_above_it(
    minimum: float, snr: float, farther: float
) -> None:
    """At 1e12 m (r/r_x)^4 is 1e-16 of the radio's own loss or less."""
    channel = ChannelConfig(reference_snr=snr)
    far = ObjectiveConfig(minimum_separation=minimum, maximum_separation=1e12)
    farthest = ObjectiveConfig(minimum_separation=minimum, maximum_separation=farther)
    assert optimal_separation(far, channel) == optimal_separation(farthest, channel)


@pytest.mark.parametrize("limit", [1e7, 1e9, 1e15, 1e20, 1e30, 1e308])
def test_a_huge_maximum_separation_acts_as_none(limit: float) -> None:
    best = optimal_separation(ObjectiveConfig(maximum_separation=limit), ChannelConfig())
    assert best == pytest.approx(70.41375740114329, rel=1e-15)  # by mpmath, of (16) without its r_x


def test_the_optimum_of_a_perfect_channel_is_the_one_computed_by_hand() -> None:
    # e^A = 1 + (r_x/r_min)^4 where p = 1, with A = (r/r_min)^4: so far out that the power overflows
    with mpmath.workdps(40):
        expected = 50 * mpmath.log1p((mpmath.mpf(1e300) / 50) ** 4) ** mpmath.mpf("0.25")
    best = optimal_separation(ObjectiveConfig(maximum_separation=1e300), ChannelConfig(model="perfect"))
    assert best == float(expected)


def test_an_optimum_below_the_smallest_float_is_the_smallest_float() -> None:
    # x/(e^x - 1) = (r/r_x)^s with an exponent of 1e-300: x = ln 2, r = 50 (ln 2)^(1e300)
    assert optimal_separation(ObjectiveConfig(shape_exponent=1e-300), ChannelConfig()) == SMALLEST


def test_summary_tracking_report_expectation_and_the_answer_of_set_give_one_optimum(tmp_path: Path) -> None:
    expected: list[dict[str, Any]] = [{"of": "optimal_separation", "above": 70.4137574, "below": 70.4137575}]
    base = load("pair.toml", run__duration=0.4, objective__maximum_separation=1e20, expect=expected)
    reports: list[Report] = []
    summary = inprocess.run(base, "pair", watch=reports.append)
    optimum = optimal_separation(base.objective, base.channel)
    effect = Run(base).change("channel.reference_snr", base.channel.reference_snr)
    assert summary["optimal_separation"] == summary["tracking"][0]["optimal_separation"] == optimum
    assert reports[-1].optimal_separation == effect.optimal_separation == optimum
    assert [verdict["holds"] for verdict in summary["expectations"]] == [True]
    assert abs(summary["edges"][0][2] - optimum) < 50.0  # the error is measured from the optimum, not from 43 m
    assert summary["separation_error_max"] == abs(summary["edges"][0][2] - optimum)
