"""Equations (3) and (4) against the paper's figures, hand algebra and a simulated fading channel."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fes.model import outage
from fes.model.config import ChannelConfig
from tests.support import reference as witness

PAPER = ChannelConfig()
PERFECT = ChannelConfig(model="perfect")

channels = st.builds(
    ChannelConfig,
    reference_snr=st.floats(1e3, 1e10),
    spectral_efficiency=st.floats(0.1, 8.0),
    path_loss_exponent=st.floats(1.5, 6.0),
    reference_distance=st.floats(0.1, 10.0),
)


@pytest.mark.parametrize(("separation", "percent"), [(68.0, 9.0017), (105.0, 29.340), (150.0, 63.669)])
def test_outage_at_the_points_of_figure_1_is_the_published_one(separation: float, percent: float) -> None:
    result = 100.0 * float(outage.outage_probability(np.array(separation), PAPER))
    assert result == pytest.approx(percent, abs=5e-4 if percent > 10 else 5e-5)  # half of the last digit


@pytest.mark.parametrize(("probability", "separation"), [(0.09, 67.995), (0.30, 105.938), (0.60, 145.090)])
def test_range_at_an_outage_is_equation_4_solved(probability: float, separation: float) -> None:
    assert outage.range_at_outage(probability, PAPER) == pytest.approx(separation, abs=5e-4)  # half a digit


def test_the_papers_channel_has_the_exponent_3e_7_cubed() -> None:
    # 2^2 - 1 = 3; SNR 1e7 at 1 m
    for r in (1.0, 10.0, 68.0, 149.0):
        assert float(outage.reception_probability(np.array(r), PAPER)) == pytest.approx(
            math.exp(-3e-7 * r**3), rel=1e-14
        )


@given(channel=channels, separation=st.floats(1.0, 300.0))
def test_reception_is_the_formula_with_its_distance_measured_in_reference_distances(
    channel: ChannelConfig, separation: float
) -> None:
    ratio = separation / channel.reference_distance
    exponent = (2.0**channel.spectral_efficiency - 1.0) / channel.reference_snr * ratio**channel.path_loss_exponent
    r = np.array([separation])
    # (r/r0)^nu against c r^nu: a few roundings, multiplied by the exponent's own size
    close = 1e-13 * (1.0 + exponent)
    assert float(outage.reception_probability(r, channel)[0]) == pytest.approx(
        math.exp(-exponent), rel=close, abs=1e-300
    )
    assert float(outage.outage_probability(r, channel)[0]) == pytest.approx(-math.expm1(-exponent), rel=close)


@given(channel=channels, probability=st.floats(1e-6, 1.0 - 1e-6))
def test_range_at_outage_equals_the_root_of_a_root_finder(channel: ChannelConfig, probability: float) -> None:
    def excess(log_ratio: float) -> float:
        exponent = (math.exp2(channel.spectral_efficiency) - 1.0) / channel.reference_snr
        return exponent * math.exp(log_ratio * channel.path_loss_exponent) + math.log1p(-probability)

    expected = channel.reference_distance * math.exp(witness.root(excess, -60.0, 60.0))
    # the root finder stops at 1e-13 of log(r), which lies within 60
    assert outage.range_at_outage(probability, channel) == pytest.approx(expected, rel=1e-11)


@given(channel=channels, probability=st.floats(1e-6, 1.0 - 1e-6))
def test_the_outage_at_the_range_of_an_outage_is_that_outage(channel: ChannelConfig, probability: float) -> None:
    r = np.array(outage.range_at_outage(probability, channel))
    # d(outage)/d(ln r) <= nu/e <= 2.3, so roundings of r hardly grow
    assert float(outage.outage_probability(r, channel)) == pytest.approx(probability, rel=1e-12, abs=1e-14)


@pytest.mark.parametrize(
    ("channel", "separation"),
    [
        (PAPER, 68.0),
        (PAPER, 105.0),
        (PAPER, 150.0),
        (ChannelConfig(reference_snr=3e4, spectral_efficiency=1.3, path_loss_exponent=2.2), 60.0),
        (ChannelConfig(reference_distance=2.0, path_loss_exponent=4.0, reference_snr=1e6), 50.0),
    ],
)
def test_a_simulated_rayleigh_link_has_the_outage_probability_of_the_formula(
    channel: ChannelConfig, separation: float
) -> None:
    samples = 400_000
    fading = np.random.default_rng(5).exponential(1.0, samples)  # |h|^2 of a unit complex Gaussian
    path = (channel.reference_distance / separation) ** channel.path_loss_exponent
    capacity = np.log2(1.0 + fading * channel.reference_snr * path)
    measured = float(np.mean(capacity < channel.spectral_efficiency))
    p = float(outage.outage_probability(np.array(separation), channel))
    assert 0.02 < p < 0.98  # or the comparison would say little
    assert measured == pytest.approx(p, abs=4.0 * math.sqrt(p * (1.0 - p) / samples))  # 4 sigma, binomial


def test_a_perfect_channel_has_no_outage_at_any_separation() -> None:
    r = np.array([0.0, 1.0, 68.0, 1e6])
    assert outage.reception_probability(r, PERFECT).tolist() == [1.0, 1.0, 1.0, 1.0]
    assert outage.outage_probability(r, PERFECT).tolist() == [0.0, 0.0, 0.0, 0.0]


def test_a_perfect_channel_has_no_range_at_an_outage() -> None:
    with pytest.raises(ValueError, match="perfect channel"):
        outage.range_at_outage(0.5, PERFECT)


@pytest.mark.parametrize("probability", [0.0, 1.0, -0.1, 1.5, math.nan])
def test_an_outage_outside_zero_to_one_is_rejected(probability: float) -> None:
    with pytest.raises(ValueError, match=r"outage must lie in \(0, 1\)"):
        outage.range_at_outage(probability, PAPER)


def test_a_channel_beyond_the_range_of_floats_is_its_limit() -> None:
    r = np.array([0.0, 1e-3, 1.0, 1e300])
    deaf = ChannelConfig(reference_snr=5e-324)
    perfect = ChannelConfig(model="perfect")
    with np.errstate(over="ignore"):
        assert outage.reception_probability(r, deaf).tolist() == [1.0, 0.0, 0.0, 0.0]
        assert outage.outage_probability(r, deaf).tolist() == [0.0, 1.0, 1.0, 1.0]
    assert outage.reception_probability(r, perfect).tolist() == [1.0] * 4
    assert outage.outage_probability(r, perfect).tolist() == [0.0] * 4


def test_a_small_efficiency_keeps_its_digits() -> None:
    # 2^delta - 1 = delta ln 2 to the last digit
    tiny = ChannelConfig(spectral_efficiency=1e-300, reference_snr=1e-300)
    assert outage.exponent_scale(tiny) == pytest.approx(math.log(2.0), rel=1e-15)
