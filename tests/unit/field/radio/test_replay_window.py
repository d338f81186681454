"""Replays: each datagram passes once, and a former start of a robot never returns."""

from hypothesis import given
from hypothesis import strategies as st

from field.radio.replay_window import (
    BOOTS,
    CROWDED,
    FORMER_START,
    MAX_ROBOTS,
    REPEATED,
    SECOND_START,
    TAKEOVER,
    TOO_OLD,
    WINDOW,
    ReplayWindow,
)

OLD, NEW, OTHER = 10, 20, 30
"""Boot ids."""


@given(st.lists(st.integers(0, 300), max_size=200))
def test_a_number_passes_once_and_only_within_the_window_below_the_highest(numbers: list[int]) -> None:
    """The same rule by a set of all numbers that have passed."""
    window, passed = ReplayWindow(), set[int]()
    for number in numbers:
        is_old = bool(passed) and number <= max(passed) - WINDOW
        expected = TOO_OLD if is_old else REPEATED if number in passed else ""
        assert window.refusal(0, OLD, number, 0) == expected
        if not expected:
            passed.add(number)


@given(st.permutations(range(WINDOW)))
def test_any_order_within_the_window_passes_whole(numbers: list[int]) -> None:
    window = ReplayWindow()
    assert [window.refusal(0, OLD, number, 0) for number in numbers] == [""] * WINDOW


def test_robots_have_windows_of_their_own() -> None:
    window = ReplayWindow()
    assert [window.refusal(robot, OLD, 5, 0) for robot in (1, 2, 1)] == ["", "", REPEATED]


def test_a_restarted_robot_is_accepted_and_its_former_start_never_returns() -> None:
    window = ReplayWindow()
    assert window.refusal(0, OLD, 1000, 0) == ""
    assert window.refusal(0, NEW, 0, TAKEOVER) == ""
    # neither what was heard of it, nor what was recorded elsewhere, nor after a long silence
    for number, now in ((1000, TAKEOVER), (1001, TAKEOVER), (2000, 1000 * TAKEOVER)):
        assert window.refusal(0, OLD, number, now) == FORMER_START
    assert window.refusal(0, NEW, 1, 1000 * TAKEOVER) == ""


def test_a_recorded_start_that_was_never_heard_does_not_replace_a_robot_that_is_heard() -> None:
    window = ReplayWindow()
    now = 0
    for number in range(100):
        now += TAKEOVER // 2
        assert window.refusal(0, NEW, number, now) == ""
        assert window.refusal(0, OTHER, number, now + 1) == SECOND_START
    assert window.refusal(0, NEW, 100, now) == ""


def test_refused_datagrams_do_not_make_a_silent_robot_seem_alive() -> None:
    window = ReplayWindow()
    window.refusal(0, OLD, 0, 0)
    assert window.refusal(0, OLD, 0, TAKEOVER - 1) == REPEATED
    assert window.refusal(0, NEW, 0, TAKEOVER) == ""


def test_the_last_former_starts_are_remembered_and_older_ones_forgotten() -> None:
    window = ReplayWindow()
    starts = range(BOOTS + 2)
    for start in starts:
        assert window.refusal(0, start, 0, start * TAKEOVER) == ""
    later = len(starts) * TAKEOVER
    assert all(window.refusal(0, start, 1, later) == FORMER_START for start in starts[1:-1])
    assert window.refusal(0, starts[0], 1, later) == ""  # the stated limit


def test_a_flood_of_robots_has_a_bound() -> None:
    window = ReplayWindow()
    assert all(window.refusal(robot, OLD, 0, 0) == "" for robot in range(MAX_ROBOTS))
    assert window.refusal(MAX_ROBOTS, OLD, 0, 0) == CROWDED
    assert window.refusal(0, OLD, 1, 0) == ""
