"""r* of a channel without a formula, against scipy, the exact optimum of a formula, and hand algebra."""

import hashlib
import math
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy import optimize

from fes.extension.context import SeededDraws, WorldContext
from fes.model import objective, outage
from fes.model.config import ObjectiveConfig
from world.config.radio import RadioConfig
from world.metrics.best_separation import best_separation
from world.metrics.optimum import optimal_separation

OBJECTIVES = (
    ObjectiveConfig(),
    ObjectiveConfig(minimum_separation=100.0),
    ObjectiveConfig(minimum_separation=3.0, maximum_separation=400.0, shape_exponent=2.5),
)


def context(preferences: ObjectiveConfig) -> WorldContext:
    return WorldContext(0.02, 2, preferences, SeededDraws(1))


def table(rows: list[tuple[float, float]]) -> RadioConfig:
    return RadioConfig(model="table", rows=rows)


def sampled(probability: Callable[[float], float], points: int = 20_001, farthest: float = 400.0) -> RadioConfig:
    """A table that samples a function densely."""
    grid = np.linspace(0.0, farthest, points).tolist()
    return table([(r, min(1.0, max(0.0, probability(r)))) for r in grid])


def preference(r: float, preferences: ObjectiveConfig = OBJECTIVES[0]) -> float:
    return float(objective.preference(np.array([r]), preferences)[0])


@pytest.mark.parametrize("preferences", OBJECTIVES)
@pytest.mark.parametrize("formula", [RadioConfig(), RadioConfig(model="logistic", logistic_midpoint=80.0)])
def test_a_dense_table_of_a_formula_has_the_optimum_of_the_formula(
    preferences: ObjectiveConfig, formula: RadioConfig
) -> None:
    dense = sampled(lambda r: float(outage.reception_probability(np.array([r]), formula)[0]))
    exact = optimal_separation(preferences, formula)
    assert best_separation(context(preferences), formula) == exact
    # Between rows 0.02 m apart a table has kinks: the maximum lies within one spacing
    assert best_separation(context(preferences), dense) == pytest.approx(exact, abs=0.02)


@pytest.mark.parametrize("preferences", OBJECTIVES)
def test_the_optimum_of_a_table_is_that_of_scipy(preferences: ObjectiveConfig) -> None:
    rows = [(0.0, 1.0), (30.0, 0.98), (80.0, 0.9), (120.0, 0.4), (300.0, 0.0)]
    x, y = np.array(rows).T

    def loss(r: float) -> float:
        return -preference(r, preferences) * float(np.interp(r, x, y))

    # one bounded search per segment between rows, where the index is smooth
    ends = [0.0, *(r for r in x.tolist() if 0 < r < preferences.maximum_separation), preferences.maximum_separation]
    parts = [
        optimize.minimize_scalar(loss, bounds=pair, method="bounded", options={"xatol": 1e-9})
        for pair in pairwise(ends)
    ]
    best = min(parts, key=lambda part: part.fun)
    # at a smooth maximum, values within 1e-16 of each other are sqrt(1e-16) of the scale apart
    assert best_separation(context(preferences), table(rows)) == pytest.approx(best.x, abs=1e-5)


def test_a_maximum_at_a_row_is_that_row() -> None:
    # certain until 60 m, then a cliff: S rises until 86 m, so J has its corner at the row
    cliff = table([(60.0, 1.0), (60.5, 0.1), (150.0, 0.0)])
    assert best_separation(context(OBJECTIVES[0]), cliff) == pytest.approx(60.0, abs=1e-6)  # golden section: 1e-9 r


def test_reception_that_rises_again_may_have_the_better_maximum_far_away() -> None:
    near = [(40.0, 1.0), (60.0, 0.1), (95.0, 0.1)]
    low, high = ([*near, (110.0, height), (130.0, 0.0)] for height in (0.3, 0.9))
    heights = [preference(r) * p for r, p in ((40.0, 1.0), (110.0, 0.3), (110.0, 0.9))]
    assert heights[1] < heights[0] < heights[2]
    assert best_separation(context(OBJECTIVES[0]), table(low)) < 50.0
    assert best_separation(context(OBJECTIVES[0]), table(high)) == pytest.approx(110.0, abs=2.0)


def test_of_a_plateau_every_place_is_an_optimum() -> None:
    # J is constant where p is proportional to 1/S
    top = preference(60.0) * 0.9

    def probability(r: float) -> float:
        if 60.0 <= r <= 80.0:
            return top / preference(r)
        return 0.9 * math.exp(-abs(r - 60.0) / 5.0) if r < 60.0 else 0.0

    best = best_separation(context(OBJECTIVES[0]), sampled(probability))
    assert 60.0 - 0.02 <= best <= 80.0 + 0.02
    value = preference(best) * float(np.interp(best, *np.array(sampled(probability).rows).T))
    assert value == pytest.approx(top, rel=1e-6)  # chords between rows 0.02 m apart


def test_a_channel_without_loss_has_the_optimum_of_the_preference() -> None:
    # S' = 0 in the variable a = (r/r_min)^4 with c = (r_min/r_x)^4: e^-a (1 + c) = c
    c = (50.0 / 150.0) ** 4
    best = best_separation(context(OBJECTIVES[0]), table([(0.0, 1.0), (1.0, 1.0)]))
    assert best == pytest.approx(50.0 * math.log((1.0 + c) / c) ** 0.25, abs=1e-5)  # flat top: sqrt(1e-16)


def test_a_channel_that_decodes_nothing_has_no_optimum() -> None:
    assert math.isnan(best_separation(context(OBJECTIVES[0]), table([(0.0, 0.0), (100.0, 0.0)])))


def test_a_trace_has_no_optimum_because_separation_does_not_determine_it(tmp_path: Path) -> None:
    path = tmp_path / "links.csv"
    path.write_text("time,sender,receiver,decoded\n0,0,1,1\n", encoding="utf-8")
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    trace = RadioConfig(model="trace", trace=str(path), trace_sha256=digest)
    assert math.isnan(best_separation(context(OBJECTIVES[0]), trace))
