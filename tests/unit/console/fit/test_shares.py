"""Shares of decoded packets: their groups, and Wilson's interval against its definition."""

import numpy as np
import pytest
from scipy import stats

from console.fit import shares
from console.fit.measurements import Packets


def test_an_interval_is_that_of_scipy() -> None:
    for decoded, sent in ((0, 10), (1, 7), (5, 10), (10, 10), (480, 500)):
        low, high = shares.wilson(np.array([decoded]), np.array([sent]))
        expected = stats.binomtest(decoded, sent).proportion_ci(0.95, method="wilson")
        assert (low[0], high[0]) == pytest.approx((expected.low, expected.high), abs=1e-12)


def test_repeated_separations_are_groups_of_their_own() -> None:
    packets = Packets(np.array([50.0, 20.0, 50.0, 20.0, 20.0]), np.array([True, True, False, True, False]))
    measured = shares.by_separation(packets)
    assert measured.separation.tolist() == [20.0, 50.0]
    assert measured.sent.tolist() == [3, 2]
    assert measured.decoded.tolist() == [2, 1]
    assert measured.share.tolist() == [2 / 3, 1 / 2]


@pytest.mark.parametrize("count", [30, 47, 400, 5000])
def test_other_separations_are_groups_of_about_equal_size_that_hold_all_packets(count: int) -> None:
    rng = np.random.default_rng(1)
    separation = rng.uniform(10.0, 100.0, count)
    measured = shares.by_separation(Packets(separation, rng.uniform(size=count) < 0.5))
    groups = len(measured.sent)
    assert groups == max(2, min(shares.MOST, count // shares.FEWEST))
    assert measured.sent.sum() == count
    assert measured.sent.max() - measured.sent.min() <= 2  # a quantile falls on a packet or between two
    assert (np.diff(measured.separation) > 0.0).all()


def test_separations_that_are_almost_all_equal_have_no_empty_group() -> None:
    separation = np.concatenate([np.full(500, 40.0), np.linspace(50.0, 90.0, 20)])
    measured = shares.by_separation(Packets(separation, np.arange(520) % 2 == 0))
    assert (measured.sent > 0).all()
    assert measured.sent.sum() == 520
