"""The gradient controller against scalar code and hand numbers."""

import math

import numpy as np
import pytest

from agents.rivals.gradient import Gradient, GradientParameters
from fes.model.config import ChannelConfig
from tests.support.surroundings import around, context, geometry, pair

RAYLEIGH = ChannelConfig()
LOGISTIC = ChannelConfig(model="logistic")


def law(channel: ChannelConfig = RAYLEIGH, n: int = 2, near_field: float = 45.0, least: float = 0.2) -> Gradient:
    parameters = GradientParameters(near_field=near_field, least_reception=least, gain=1000.0)
    return Gradient(parameters, context(n, channel))


def pull(controller: Gradient, separation: float) -> float:
    """Pull of the first of two robots toward the second [m]."""
    seen = around(pair(separation))
    formed = controller.step(None, seen, geometry(seen, 60.0))
    assert formed.pull[0, 0] == -formed.pull[1, 0]
    assert not formed.pull[:, 1].any()
    return float(formed.pull[0, 0])


def quality(separation: float, channel: ChannelConfig) -> float:
    """phi(r), written down again with the paper's numbers: 3e-7 = (2^2 - 1) / 1e7."""
    reception = {
        "rayleigh": math.exp(-3e-7 * separation**3),
        "logistic": 1.0 / (1.0 + math.exp((separation - 100.0) / 12.0)),
        "perfect": 1.0,
    }[str(channel.model)]
    return separation / math.hypot(separation, 45.0) * reception


@pytest.mark.parametrize("channel", [RAYLEIGH, LOGISTIC, ChannelConfig(model="perfect")], ids=lambda c: str(c.model))
@pytest.mark.parametrize("separation", [20.0, 60.0, 90.0])
def test_the_pull_is_the_gain_times_the_slope_of_the_link_quality(channel: ChannelConfig, separation: float) -> None:
    # a central difference of h = 1e-3 m errs by h^2 phi'''/6, less than 1e-10 of these slopes' scale
    slope = (quality(separation + 1e-3, channel) - quality(separation - 1e-3, channel)) / 2e-3
    assert pull(law(channel), separation) == pytest.approx(-1000.0 * slope, abs=1e-6)


def test_two_robots_rest_where_near_field_and_reception_balance() -> None:
    # phi' = 0 at r: r_0^2 / (r^2 + r_0^2) = 3 c r^3. At r = 60 m that is 0.1944, so r_0^2 = 0.1944 / 0.8056 * 3600.
    controller = law(near_field=math.sqrt(0.1944 / 0.8056 * 3600.0))
    assert pull(controller, 60.0) == pytest.approx(0.0, abs=1e-9)
    assert pull(controller, 59.0) < 0.0 < pull(controller, 61.0)


def test_a_peer_below_the_least_reception_is_not_a_neighbor() -> None:
    limit = (-math.log(0.7) / 3e-7) ** (1.0 / 3.0)  # 105.9 m, the paper's 30 %
    assert pull(law(least=0.7), limit - 0.01) > 0.0
    assert pull(law(least=0.7), limit + 0.01) == 0.0


def test_the_details_are_the_mean_quality_and_distance_of_the_neighbors() -> None:
    seen = around(np.array([[0.0, 0.0], [60.0, 0.0], [0.0, 80.0]]))
    formed = law(n=3).step(None, seen, geometry(seen, 60.0))
    assert formed.details is not None
    expected = [0.5 * (quality(60.0, RAYLEIGH) + quality(80.0, RAYLEIGH)), 70.0]
    assert formed.details[0] == pytest.approx(expected)
