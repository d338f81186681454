"""Fits of known channels: the maximum by scipy, the coverage of the intervals, and shapes without a fit."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from scipy import optimize, stats

from console.fit import estimate, likelihood
from console.fit.estimate import Fit
from console.fit.measurements import Packets, Powers
from fes.arrays.types import Bools, Floats
from fes.errors import FesError
from fes.model.config import ObjectiveConfig
from tests.support import measured_links
from world.config.radio import RadioConfig
from world.metrics.optimum import optimal_separation

OPTIMAL = 68.113761
"""r* of the paper's channel [m]."""


def snr(fit: Fit, separation: float) -> float:
    """SNR / (2^delta - 1) of a rayleigh fit at a separation: c r^nu of (3) is its inverse."""
    settings = fit.settings
    ratio = separation / settings["reference_distance"]
    return float(
        settings["reference_snr"]
        / (2.0 ** settings["spectral_efficiency"] - 1.0)
        * ratio ** -settings["path_loss_exponent"]
    )


def witness(loss: Callable[[Floats], float], start: list[float]) -> Floats:
    """The minimum of a negative log-likelihood, without slopes."""
    options = {"xatol": 1e-10, "fatol": 1e-12, "maxiter": 10_000, "maxfev": 10_000}
    found = optimize.minimize(loss, start, method="Nelder-Mead", options=options)
    assert found.success
    parameters: Floats = found.x
    return parameters


def log_loss(probability: Floats, decoded: Bools) -> float:
    return -float(np.log(np.where(decoded, probability, 1.0 - probability)).sum())


# The search sees the sum only to 1e-13 of about 200, so a parameter to about 1e-6 of its standard error; six digits
# are printed.
DIGITS = 2e-5


def test_scipy_finds_the_same_rayleigh_channel() -> None:
    packets = measured_links.packets(measured_links.rayleigh, 3)
    fit = estimate.fit(packets, "rayleigh", 2.0)

    def loss(parameters: Floats) -> float:
        level, exponent = parameters
        return log_loss(np.exp(-np.exp(level) * (packets.separation / 80.0) ** exponent), packets.decoded)

    level, exponent = witness(loss, [-1.0, 2.0])
    assert fit.settings["path_loss_exponent"] == pytest.approx(exponent, rel=DIGITS)
    assert snr(fit, 80.0) == pytest.approx(math.exp(-level), rel=DIGITS)
    assert fit.log_likelihood == pytest.approx(-loss(np.array([level, exponent])), abs=1e-9)


def test_scipy_finds_the_same_logistic_channel() -> None:
    packets = measured_links.packets(measured_links.logistic, 3)
    fit = estimate.fit(packets, "logistic", 2.0)

    def loss(parameters: Floats) -> float:
        midpoint, width = parameters
        return log_loss(1.0 / (1.0 + np.exp((packets.separation - midpoint) / width)), packets.decoded)

    midpoint, width = witness(loss, [80.0, 20.0])
    assert fit.settings["logistic_midpoint"] == pytest.approx(midpoint, rel=DIGITS)
    assert fit.settings["logistic_width"] == pytest.approx(width, rel=DIGITS)


@pytest.mark.parametrize("decoded_only", [False, True])
def test_scipy_finds_the_same_mean_power(decoded_only: bool) -> None:
    powers = measured_links.powers(3, -80.0, decoded_only)
    fit = estimate.fit(powers, "rayleigh", 2.0)
    linear = 10.0 ** (powers.rssi / 10.0 + 8.0)  # relative to -80 dBm

    def loss(parameters: Floats) -> float:
        mean = np.exp(parameters[0]) * (powers.separation / 80.0) ** -parameters[1]
        # a truncated exponential distribution: density e^(-x/m) / m over the probability e^(-1/m) to exceed 1
        return -float((-linear / mean - np.log(mean) + (1.0 / mean if decoded_only else 0.0)).sum())

    level, exponent = witness(loss, [0.0, 2.0])
    assert fit.settings["path_loss_exponent"] == pytest.approx(exponent, rel=DIGITS)
    assert snr(fit, 80.0) == pytest.approx(math.exp(level), rel=DIGITS)
    assert snr(fit, 80.0) == pytest.approx(10 ** ((-20.0 - 30.0 * math.log10(80.0) + 80.0) / 10.0), rel=0.15)


FAMILIES = {
    "outage": (likelihood.outage, [0.0, 1.0]),
    "logistic": (likelihood.logistic, [0.0, 1.0]),
    "faded power": (likelihood.faded_power, [0.3, 2.0]),
}


@pytest.mark.parametrize("name", FAMILIES)
def test_derivatives_of_a_likelihood_are_those_of_central_differences(name: str) -> None:
    family, values = FAMILIES[name]
    for y in values:
        for eta in (-6.0, -1.0, 0.0, 0.7, 2.5):
            step = 1e-4
            low, middle, high = (family(np.array([x]), np.array([y])) for x in (eta - step, eta, eta + step))
            # errors of order step^2 and of 1e-16 / step, times values of order 12
            slope = float((high.value - low.value)[0] / (2.0 * step))
            assert middle.slope[0] == pytest.approx(slope, rel=1e-6, abs=1e-9)
            curvature = float((high.slope - low.slope)[0] / (2.0 * step))
            assert middle.curvature[0] == pytest.approx(curvature, rel=1e-6, abs=1e-9)
            assert middle.curvature[0] < 0.0


@pytest.mark.parametrize("name", FAMILIES)
def test_a_likelihood_stays_a_number_far_away(name: str) -> None:
    family, values = FAMILIES[name]
    for y in values:
        terms = family(np.array([-1e5, -700.0, 700.0, 1e5]), np.full(4, y))
        assert not any(np.isnan(part).any() for part in terms)
        assert (np.diff(terms.slope) <= 0.0).all()  # concave


DRAWS = 200
LOWEST, HIGHEST = (int(stats.binom.ppf(end, DRAWS, 0.95)) for end in (1e-4, 1 - 1e-4))
"""Numbers of covering intervals of 200 that occur with probability 0.9998, if each covers with 95 %."""


def covering(draw: Callable[[int], Packets | Powers], model: str, truth: dict[str, Callable[[Fit], float]]) -> None:
    counts = dict.fromkeys(truth, 0)
    for seed in range(DRAWS):
        fit = estimate.fit(draw(seed), model, 2.0)
        intervals = {**fit.intervals, "r*": fit.optimal_interval}
        for name, value in truth.items():
            low, high = intervals[name] or (math.nan, math.nan)
            counts[name] += low <= value(fit) <= high
    for name, count in counts.items():
        assert LOWEST <= count <= HIGHEST, (name, count)


def true_snr(fit: Fit) -> float:
    """SNR of exp(-3e-7 r^3) at the reference distance of a fit, which depends on the draw."""
    return float(1e7 * fit.settings["reference_distance"] ** -3.0)


def test_the_bounds_of_coverage_would_notice_intervals_of_80_percent() -> None:
    assert (LOWEST, HIGHEST) == (177, 199)
    assert stats.binom.cdf(LOWEST - 1, DRAWS, 0.8) > 0.99


def test_intervals_of_a_rayleigh_channel_cover_the_truth_in_95_of_100_draws() -> None:
    covering(
        lambda seed: measured_links.packets(measured_links.rayleigh, seed),
        "rayleigh",
        {"reference_snr": true_snr, "path_loss_exponent": lambda fit: 3.0, "r*": lambda fit: OPTIMAL},
    )


def test_intervals_of_a_logistic_channel_cover_the_truth_in_95_of_100_draws() -> None:
    channel = RadioConfig(model="logistic", logistic_midpoint=90.0, logistic_width=12.0)
    optimal = optimal_separation(ObjectiveConfig(), channel)
    covering(
        lambda seed: measured_links.packets(measured_links.logistic, seed),
        "logistic",
        {"logistic_midpoint": lambda fit: 90.0, "logistic_width": lambda fit: 12.0, "r*": lambda fit: optimal},
    )


@pytest.mark.parametrize("decoded_only", [False, True])
def test_intervals_of_received_power_cover_the_truth_in_95_of_100_draws(decoded_only: bool) -> None:
    def power(fit: Fit) -> float:
        """3 times the mean power over -80 dBm at the reference distance."""
        return float(3.0 * 10.0 ** ((60.0 - 30.0 * math.log10(fit.settings["reference_distance"])) / 10.0))

    covering(
        lambda seed: measured_links.powers(seed, -80.0, decoded_only),
        "rayleigh",
        {"reference_snr": power, "path_loss_exponent": lambda fit: 3.0},
    )


def test_power_of_decoded_packets_alone_would_mislead_a_fit_that_ignores_the_lost_ones() -> None:
    powers = measured_links.powers(1, -80.0, decoded_only=True, count=20_000)
    assert powers.are_decoded
    assert estimate.fit(powers, "rayleigh", 2.0).settings["path_loss_exponent"] == pytest.approx(3.0, abs=0.1)
    ignored = powers._replace(rssi=np.append(powers.rssi, -81.0), separation=np.append(powers.separation, 150.0))
    assert not ignored.are_decoded  # one row below the threshold: all of them count as complete
    assert estimate.fit(ignored, "rayleigh", 2.0).settings["path_loss_exponent"] < 2.5


def test_the_deviation_of_rayleigh_faded_power_is_its_mean() -> None:
    for decoded_only in (False, True):
        spread = estimate.fit(measured_links.powers(2, -80.0, decoded_only, 20_000), "rayleigh", 2.0).spread
        assert spread == pytest.approx(1.0, abs=4 * math.sqrt(2.0 / 10_000))  # of an exponential: var s^2 = 8/n
    steady = measured_links.powers(2, -150.0, False, 2000)
    mean = -20.0 - 30.0 * np.log10(steady.separation)
    assert estimate.fit(steady._replace(rssi=mean), "rayleigh", 2.0).spread == pytest.approx(0.0, abs=1e-6)


def test_the_band_holds_the_curve_and_at_each_separation_the_truth_in_95_of_100_draws() -> None:
    separation = np.array([30.0, 60.0, 90.0, 120.0, 150.0])
    for probability, model in ((measured_links.rayleigh, "rayleigh"), (measured_links.logistic, "logistic")):
        counts = np.zeros(5)
        for seed in range(DRAWS):
            value, low, high = estimate.fit(measured_links.packets(probability, seed), model, 2.0).band(separation)
            assert ((low < value) & (value < high)).all()
            counts += (low <= probability(separation)) & (probability(separation) <= high)
        assert ((counts >= LOWEST) & (counts <= HIGHEST)).all(), counts


def test_a_table_has_the_measured_shares_as_rows() -> None:
    separation = np.repeat([20.0, 60.0, 100.0], 4)
    decoded = np.array([1, 1, 1, 1, 1, 0, 1, 1, 0, 0, 0, 1], dtype=np.bool_)
    fit = estimate.fit(Packets(separation, decoded), "table", 2.0)
    assert fit.settings == {"model": "table", "rows": [[20.0, 1.0], [60.0, 0.75], [100.0, 0.25]]}
    assert fit.log_likelihood == pytest.approx(2 * (3 * math.log(0.75) + math.log(0.25)), rel=1e-12)
    value, low, high = fit.band(np.array([0.0, 40.0, 200.0]))
    assert value.tolist() == [1.0, 0.875, 0.25]
    assert (low < value).all()
    assert high[0] == 1.0


def packets(*decoded_and_lost: list[float]) -> Packets:
    decoded, lost = decoded_and_lost
    return Packets(np.array([*decoded, *lost]), np.array([True] * len(decoded) + [False] * len(lost)))


@pytest.mark.parametrize("model", ["rayleigh", "logistic"])
@pytest.mark.parametrize(
    ("measured", "rule"),
    [
        (packets([20.0, 30.0], [60.0, 70.0]), "every packet up to 30 m decoded and every one from 60 m on was lost"),
        (packets([20.0, 60.0], [60.0, 70.0]), "every packet up to 60 m decoded and every one from 60 m on was lost"),
        (packets([60.0, 70.0], [20.0, 30.0]), "reception does not fall with separation: --model table"),
        (packets([30.0, 60.0, 70.0], [20.0, 50.0]), "--model table"),
    ],
)
def test_packets_without_a_fit_are_refused_in_one_line(measured: Packets, rule: str, model: str) -> None:
    with pytest.raises(FesError, match=rule) as caught:
        estimate.fit(measured, model, 2.0)
    assert "\n" not in str(caught.value)


def test_received_power_is_fitted_by_the_model_of_its_fading_only() -> None:
    for model in ("logistic", "table"):
        with pytest.raises(FesError, match=f"received power has a fit of model 'rayleigh' only, not '{model}'"):
            estimate.fit(measured_links.powers(1, -80.0, False), model, 2.0)


def test_the_spectral_efficiency_is_chosen_and_moves_no_reception() -> None:
    measured = measured_links.packets(measured_links.rayleigh, 3)
    first, second = (estimate.fit(measured, "rayleigh", efficiency) for efficiency in (2.0, 0.5))
    assert second.settings["reference_snr"] == pytest.approx(
        first.settings["reference_snr"] / 3.0 * (math.sqrt(2.0) - 1.0), rel=1e-5
    )
    assert second.optimal == pytest.approx(first.optimal, abs=1e-4)  # fields have six digits
