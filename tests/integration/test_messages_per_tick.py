"""Messages per tick at the router, as in docs/explanation/scaling.md: counted, and compared with the world's."""

import shutil

import pytest

from bench.size import growth
from tests.support.loop import load


@pytest.mark.skipif(shutil.which("ss") is None, reason="growth: skipped, because there is no ss (iproute2)")
def test_a_tick_takes_an_observation_a_beacon_and_a_command_per_robot_and_a_delivery_per_contact(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # A robot that pauses would get, and count, an observation twice.
    monkeypatch.setattr("world.execution.barrier.RESEND_AFTER", 60.0)
    robots, ticks = 6, growth.FIRST + growth.TICKS
    measured = growth.measure(load("hundred.toml", robots__count=robots, run__duration=(ticks + 5) * 0.02))
    # The window does not end at the same moment for each robot: each may be one tick off, at both ends.
    share = 2.0 / growth.TICKS
    assert measured.incoming == pytest.approx(2 * robots, rel=share)
    assert measured.outgoing == pytest.approx(robots * (1.0 + measured.contacts), rel=share)
    assert measured.contacts > 2.0  # otherwise few beacons would be counted
    payload = sum(measured.counts[f"{kind}, bytes"] for kind in ("beacon taken", "observation taken"))
    assert payload < measured.sent < payload + 200.0 * measured.outgoing
