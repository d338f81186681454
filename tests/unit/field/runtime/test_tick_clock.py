"""Ticks of a robot's clock."""

from hypothesis import given
from hypothesis import strategies as st

from field.runtime.tick_clock import TickClock

DT = st.sampled_from([0.005, 0.02, 0.05, 0.1, 1.0])
WALL = st.integers(0, 4 * 10**18)
MONOTONIC = st.integers(0, 10**18)
LATER = st.integers(0, 10**13)


@given(DT, WALL, MONOTONIC, LATER)
def test_a_time_lies_in_the_tick_that_it_is_given(dt: float, wall: int, monotonic: int, later: int) -> None:
    clock, now = TickClock(dt, wall, monotonic), monotonic + later
    tick = clock.tick(now)
    assert clock.start(tick) <= now < clock.start(tick + 1)


@given(DT, WALL, MONOTONIC, MONOTONIC, LATER)
def test_two_robots_with_one_wall_clock_count_the_same_ticks(
    dt: float, wall: int, first: int, second: int, later: int
) -> None:
    one, other = TickClock(dt, wall, first), TickClock(dt, wall, second)
    assert one.tick(first + later) == other.tick(second + later)


def test_a_tick_is_that_of_the_wall_clock() -> None:
    assert TickClock(0.02, wall=60 * 10**9, monotonic=5).tick(5) == 3000
