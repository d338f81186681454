"""Permits of operators: one operator at a time, each Permit once, and only young ones."""

import pytest

from fes.protocol.robot_control import STOPPED, Permit
from field.gate.rules import permits
from field.gate.rules.permits import Permits
from tests.support.gates import Rig, running

SECOND = 1_000_000_000


def test_an_operator_beyond_the_largest_number_takes_the_place_of_the_one_heard_least_recently() -> None:
    rig = Rig()
    for operator in range(permits.MAX_OPERATORS):
        rig.now += 2.0
        rig.permit(operator)
    rig.now += 2.0
    rig.permit(0)  # heard again: the least recent one is operator 1
    rig.permit(1000)
    assert 1000 not in rig.gate.permits.heard  # the permit of operator 0 is live
    rig.now += 2.0
    rig.permit(1000)
    assert rig.gate.permits.operator == 1000
    assert len(rig.gate.permits.heard) == permits.MAX_OPERATORS
    assert {0, 2, 1000} <= rig.gate.permits.heard.keys()
    assert 1 not in rig.gate.permits.heard


def test_an_old_permit_of_a_known_operator_is_refused_after_it_has_lapsed() -> None:
    rig = Rig()
    rig.permit(operator=1, number=7)
    rig.now += 2.0
    rig.permit(operator=2, number=1)
    rig.now += 2.0
    rig.permit(operator=1, number=7)
    assert rig.gate.permits.operator == 2


def renewed(rig: Rig, seconds: float, delay: float) -> None:
    """Permits arrive five times per second, `delay` [s] after they were sent; everything else works."""
    for tick in range(round(seconds / 0.02)):
        if tick % 10 == 0:
            rig.permit(delay=delay)
        rig.see()
        rig.command(0.1)
        rig.tick()


def test_a_steady_delay_is_not_an_age_and_a_delay_that_grows_stops_the_robot() -> None:
    rig = running(0.1)
    renewed(rig, 2.0, delay=0.9)
    assert rig.status.mode != STOPPED
    renewed(rig, 0.8, delay=1.1)  # the last young one still holds
    assert rig.status.mode != STOPPED
    renewed(rig, 1.0, delay=1.1)
    assert (rig.status.mode, rig.status.reason) == (STOPPED, "the operator's permit has lapsed")


def test_permits_that_waited_in_a_cut_link_do_not_move_the_robot_and_later_ones_permit_again() -> None:
    rig = running(0.1)
    for _ in range(100):  # a cut of two seconds
        rig.see()
        rig.command(0.1)
        rig.tick()
    assert rig.status.mode == STOPPED
    for waited in (1.9, 1.5, 1.1):
        rig.permit(delay=waited)
    assert "permit" in rig.start()
    rig.permit(delay=0.1)
    assert rig.start() == ""


@pytest.mark.parametrize("drift", [-2e-4, 2e-4])
def test_clocks_that_drift_for_a_day_are_not_an_age(drift: float) -> None:
    """Quartz drifts by up to 1e-4, two clocks by twice as much: 17 s per day."""
    known, now = Permits(), 0.0
    for sequence in range(86_400):
        now = float(sequence)
        known = permits.received(known, 1.0, now, Permit(1, sequence, round(SECOND * (now * (1 + drift) + 1000))))
        assert known.arrival == now


def test_the_clock_of_an_operator_whose_machine_slept_is_compared_anew() -> None:
    known = permits.received(Permits(), 1.0, 0.0, Permit(1, 0, 5 * SECOND))
    known = permits.received(known, 1.0, 3600.0, Permit(1, 1, 6 * SECOND))
    assert known.arrival == 3600.0
