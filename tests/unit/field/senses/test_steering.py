"""Steering of an offset: a change of one tick for drift, none for hiccups, and never back and forth."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from field.senses.steering import BEACONS, LEAST, MOST, TICKS, Steering


def shifts(slacks: list[float], apart: float = 1.0) -> list[int]:
    """The changes after each of these slacks; beacons arrive some ticks apart."""
    steering = Steering()
    return [steering.shift(slack, apart * number) for number, slack in enumerate(slacks)]


@given(st.floats(LEAST, MOST))
def test_between_its_bounds_an_offset_remains(slack: float) -> None:
    assert not any(shifts([slack] * 3 * BEACONS))


@given(st.floats(-1.0 + LEAST, LEAST, exclude_max=True) | st.floats(MOST, MOST + 1.0, exclude_min=True))
def test_outside_of_them_it_changes_by_one_tick_and_then_remains(slack: float) -> None:
    changes = shifts([slack] * BEACONS)
    assert changes[:-1] == [0] * (BEACONS - 1)
    assert changes[-1] == (1 if slack < LEAST else -1)
    assert not any(shifts([slack + changes[-1]] * BEACONS))


@given(st.floats(-100.0, 100.0))
def test_any_offset_is_within_the_bounds_after_two_changes(slack: float) -> None:
    for _ in range(2):
        slack += sum(shifts([slack] * BEACONS))
    assert LEAST <= slack <= MOST


@pytest.mark.parametrize("late", [0.0, -40.0])
def test_three_beacons_of_a_window_that_are_late_by_a_hiccup_change_nothing(late: float) -> None:
    usual = [1.0] * (BEACONS - 3)
    assert not any(shifts([*usual, late, late, late]))
    assert shifts([*usual[1:], late, late, late, late])[-1] == 1  # a fourth: one tick, as others are in time


def test_a_window_of_a_lossy_link_ends_after_a_time() -> None:
    changes = shifts([0.0] * 6, apart=TICKS / 5)
    assert changes == [0, 0, 0, 0, 0, 1]
