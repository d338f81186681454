"""The metrics of a team in a run, against what its ticks say by themselves."""

import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from console.backends import inprocess
from fes.arrays.types import Floats
from fes.errors import ScenarioError
from tests.support.loop import load
from world.config.scenario import Scenario

ALL = [
    {"use": "link_index", "window": 2.0, "tolerance": 0.05},
    {"use": "covered_area"},
    {"use": "delivery"},
    {"use": "links_connected"},
    {"use": "travel"},
]


def scenario(name: str, **overrides: Any) -> Scenario:
    return load(name, metric=ALL, **overrides)


def metrics(of: Scenario) -> dict[str, dict[str, float]]:
    found: dict[str, dict[str, float]] = inprocess.run(of, "x")["metrics"]
    return found


def indices(of: Scenario) -> tuple[Floats, Floats]:
    """The mean of J over the links at each tick, and the share of ticks with links between all of two robots."""
    values, connected = [], []
    for tick in inprocess.ticks(of):
        links, poses = tick.telemetry.links, tick.state.poses
        chosen = [(a, b) for a, b in zip(links.rows, links.peers, strict=True) if a < b]
        lengths = [math.hypot(*(poses[a, :2] - poses[b, :2])) for a, b in chosen]
        # the reception of the beacon of the tick before is that at the separation of that tick
        values.append([math.nan] if not lengths else [index(length) for length in lengths])
        connected.append(bool(lengths))
    return np.array([np.mean(row) if not math.isnan(row[0]) else 0.0 for row in values]), np.array(connected)


def index(r: float) -> float:
    return (1.0 - math.exp(-((r / 50.0) ** 4))) * math.exp(-((r / 150.0) ** 4)) * math.exp(-3e-7 * r**3)


def test_the_index_settles_when_it_stays_close_to_its_mean_at_the_end() -> None:
    run = scenario("pair.toml", run__duration=8.0)
    values, connected = indices(run)
    result = metrics(run)
    # a beacon's probability is a tick older than the separation: at most 5 m/s or so, 0.1 m, 0.002 of J
    assert result["link_index"]["mean"] == pytest.approx(values[-100:].mean(), abs=0.002)
    assert result["link_index"]["links"] == 1.0
    outside = [tick for tick, value in enumerate(values) if abs(value / values[-100:].mean() - 1.0) > 0.05]
    assert result["link_index"]["settled_at"] == pytest.approx(0.02 * (outside[-1] + 1), abs=0.021)
    assert 0.0 < result["link_index"]["settled_at"] < 8.0
    assert result["links_connected"] == {"share": connected.mean(), "at_end": 1.0}


def test_an_index_that_still_moves_within_the_window_has_not_settled() -> None:
    assert metrics(scenario("pair.toml", run__duration=0.5))["link_index"]["settled_at"] is None


def test_the_path_lengths_are_sums_of_steps() -> None:
    run = scenario("paper.toml", run__duration=2.0)
    positions = np.array([tick.state.poses[:, :2] for tick in inprocess.ticks(run)])
    lengths = [sum(math.dist(*step) for step in pairwise(path)) for path in positions.swapaxes(0, 1)]
    assert metrics(run)["travel"] == pytest.approx({"mean": sum(lengths) / 10, "largest": max(lengths)}, rel=1e-12)


def test_area_and_delivery_are_those_of_the_last_tick() -> None:
    run = scenario("pair.toml", run__duration=8.0)
    *_, before, last = inprocess.ticks(run)
    apart, earlier = (math.dist(*tick.state.poses[:, :2]) for tick in (last, before))
    half = apart / 2.0
    lens = 2.0 * 2500.0 * math.acos(half / 50.0) - 2.0 * half * math.sqrt(2500.0 - half**2)
    result = metrics(run)
    area = 2.0 * math.pi * 2500.0 - lens
    assert result["covered_area"] == pytest.approx({"area": area, "share": area / (math.pi * 5000.0)}, rel=1e-12)
    quality = math.exp(-((apart / 150.0) ** 4)) * math.exp(-3e-7 * earlier**3)
    assert result["delivery"] == pytest.approx(dict.fromkeys(result["delivery"], quality), rel=1e-9)


def test_an_absent_robot_covers_nothing_and_delivers_nothing() -> None:
    leaving = [{"at": 1.0, "kill": [1]}]
    result = metrics(scenario("pair.toml", run__duration=3.0, event=leaving))
    assert result["covered_area"]["area"] == pytest.approx(math.pi * 2500.0)
    assert set(result["delivery"].values()) == {None}


def test_a_radius_of_its_own_is_a_parameter() -> None:
    run = load("pair.toml", run__duration=0.1, metric=[{"use": "covered_area", "radius": 1.0}])
    assert metrics(run)["covered_area"]["area"] == pytest.approx(2.0 * math.pi)


def test_a_metric_may_stand_twice_under_two_names() -> None:
    small, large = {"use": "covered_area", "radius": 1.0}, {"use": "covered_area", "radius": 10.0, "name": "far"}
    result = metrics(load("pair.toml", run__duration=0.1, metric=[small, large]))
    assert result["covered_area"]["area"] == pytest.approx(2.0 * math.pi)
    assert result["far"]["area"] == pytest.approx(200.0 * math.pi)


@pytest.mark.parametrize(
    ("first", "second"),
    [
        ({"use": "travel"}, {"use": "travel"}),
        ({"use": "delivery", "name": "travel"}, {"use": "travel"}),
        ({"use": "one:travel"}, {"use": "two:Lab.travel"}),
    ],
)
def test_two_metrics_under_one_name_are_refused(first: dict[str, str], second: dict[str, str]) -> None:
    text = "metric: two metrics have the name 'travel' in the summary: give one another `name`"
    with pytest.raises(ScenarioError, match=text):
        load("pair.toml", metric=[first, {"use": "delivery"}, second])
