"""Times to the optimum, and separations averaged over a period, against hand-made series."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fes.arrays.edges import Edges
from tests.support import layouts
from world.metrics.period_average import PeriodAverage
from world.metrics.tracking import TeamErrors, Tracking

DT = 0.5  # s; 10 s are 20 ticks


def follow(errors: Sequence[float], changes: Sequence[int] = ()) -> list[dict[str, Any]]:
    tracking = Tracking(DT)
    for tick, error in enumerate(errors):
        team = TeamErrors(error, abs(error), 2.0 * abs(error), 0.5)
        tracking.add(tick, 68.0 - len(changes), tick in changes, team)
    return tracking.table()


@pytest.mark.parametrize(
    ("errors", "expected"),
    [
        ([5.0] * 10 + [0.9] * 20, 5.0),
        ([5.0] * 10 + [0.9] * 19, None),
        ([5.0] * 10 + [0.9] * 19 + [1.0] + [-0.9] * 20, 15.0),
        ([math.nan] * 4 + [0.0] * 20, 2.0),
        ([0.0] * 20 + [9.0] * 20, 0.0),
    ],
)
def test_the_optimum_is_found_from_the_first_tick_that_holds_for_ten_seconds(
    errors: list[float], expected: float | None
) -> None:
    assert follow(errors)[0]["time_to_1m"] == expected


def test_after_a_change_five_seconds_suffice_and_times_count_from_the_change() -> None:
    errors = [0.0] * 30 + [2.5] * 8 + [0.5] * 10
    first, second = follow(errors, changes=[30])
    assert (first["at"], first["time_to_1m"]) == (0.0, 0.0)
    assert (second["at"], second["time_to_1m"]) == (15.0, 4.0)
    assert follow(errors[:-1], changes=[30])[1]["time_to_1m"] is None


def test_errors_are_averaged_from_a_minute_after_the_start_or_the_change() -> None:
    errors = [9.0] * 120 + [1.0, -2.0, 3.0] + [7.0] * 121
    first, second = follow(errors, changes=[123])
    assert first["bias"] == pytest.approx(2.0 / 3.0)
    assert first["rmse"] == pytest.approx(math.sqrt(14.0 / 3.0))
    assert first["separation_rmse"] == pytest.approx(2.0 * math.sqrt(14.0 / 3.0))
    assert first["disagreement_max"] == 3.0
    assert first["index"] == 0.5
    assert second["bias"] == second["rmse"] == 7.0
    assert [follow([1.0] * 100)[0][name] for name in ("bias", "rmse", "index", "disagreement_max")] == [None] * 4


def test_a_breathing_separation_is_averaged_over_the_latest_whole_period() -> None:
    links, period = layouts.edges([0, 1], [(0, 1), (1, 0)]), 40
    average, seen = PeriodAverage(period), []
    for tick in range(200):
        average.add(links, np.array([70.0 + 0.01 * tick + 5.0 * math.sin(2.0 * math.pi * tick / period)]))
        seen.append(float(average.mean[0]) if len(average.mean) else math.nan)
    assert all(math.isnan(mean) for mean in seen[: period - 1])
    for tick in range(period - 1, 200):
        last = tick - (tick + 1) % 2  # blocks of two ticks
        # the sine has no mean over a period; the drift's is that of its middle
        assert seen[tick] == pytest.approx(70.0 + 0.01 * (last - (period - 1) / 2.0), abs=1e-9)


def test_a_period_of_one_tick_averages_nothing() -> None:
    average = PeriodAverage(1)
    for separation in (70.0, 75.0):
        average.add(layouts.edges([0, 1], [(0, 1)]), np.array([separation]))
        assert average.mean.tolist() == [separation]


@given(
    period=st.sampled_from([4, 6, 7, 40]),
    story=st.lists(st.sets(st.sampled_from([(0, 1), (1, 0), (1, 2), (2, 1), (0, 2)])), min_size=1, max_size=60),
)
def test_a_link_keeps_its_average_while_it_exists(period: int, story: list[set[tuple[int, int]]]) -> None:
    """Against a plain list of a link's separations since it last appeared, on either side."""
    average, since = PeriodAverage(period), dict[tuple[int, int], list[float]]()
    known: dict[frozenset[tuple[int, int]], Edges] = {}
    blocks = next(count for count in range(min(20, period), 0, -1) if period % count == 0)
    length = period // blocks
    for tick, pairs in enumerate(story):
        key = frozenset(pairs)
        links = known.setdefault(key, layouts.edges(range(3), pairs))
        ends = [tuple(sorted(pair)) for pair in zip(links.rows.tolist(), links.peers.tolist(), strict=True)]
        now = [ends[position] for position in links.undirected.tolist()]
        assert len(set(now)) == len(now)
        values = {pair: 60.0 + 7.0 * pair[0] + pair[1] + 0.37 * tick for pair in now}
        since = {pair: [*since.get(pair, []), values[pair]] for pair in now}
        average.add(links, np.array([values[pair] for pair in now]))
        end = (tick + 1) % length  # ticks since the last whole block
        for pair, mean in zip(now, average.mean.tolist() if len(average.mean) else [math.nan] * 9, strict=False):
            segment = since[pair][: len(since[pair]) - end]
            if len(segment) >= period + length:  # it existed in all blocks, even if it appeared within one
                assert mean == pytest.approx(float(np.mean(segment[-period:])))
            elif len(segment) < period:
                assert math.isnan(mean)
