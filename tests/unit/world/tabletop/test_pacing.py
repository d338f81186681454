"""Steps that are due in real time."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from world.tabletop.pacing import LONGEST, Pacing


def test_steps_are_due_at_their_deadlines_and_not_before() -> None:
    pacing = Pacing(0.005, 100.0)
    assert pacing.next == pytest.approx(100.005)
    assert [pacing.due(now) for now in (100.0, 100.0049, 100.005, 100.0051, 100.012, 100.03)] == [0, 0, 1, 0, 1, 4]
    assert pacing.lost == 0.0


def test_a_short_delay_is_made_up_for_and_the_rest_of_a_long_one_is_lost() -> None:
    pacing = Pacing(0.005, 0.0)
    assert pacing.due(0.08) == 16
    assert pacing.due(10.08) == 20  # 0.1 s: the bodies do not jump by 10 s of their last commands
    assert pacing.lost == pytest.approx(9.9)
    assert pacing.next == pytest.approx(10.085)
    assert pacing.due(10.09) == 2


@given(st.lists(st.floats(0.0, 0.5), max_size=60), st.sampled_from([0.0005, 0.002, 0.005, 0.02]))
@settings(max_examples=100, deadline=None)
def test_the_time_of_the_bodies_and_the_lost_time_add_up_to_real_time(delays: list[float], step: float) -> None:
    pacing, now, done = Pacing(step, 7.0), 7.0, 0
    for delay in delays:
        now += delay
        steps = pacing.due(now)
        assert 0 <= steps * step <= LONGEST + step
        done += steps
        assert done * step + pacing.lost <= now - 7.0 + 1e-6
        assert done * step + pacing.lost > now - 7.0 - step - 1e-6
