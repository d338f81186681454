"""The robots that take part at a tick, as tokens appear and are lost."""

import numpy as np

from fes.arrays.types import Bools
from fes.protocol.messages import Join
from world.config.events import ParticipationChange
from world.execution.hosting import Membership
from world.execution.lifecycle import Lifecycle

BOTH = np.array([True, True])


def running(*joins: Join, schedule: dict[int, ParticipationChange] | None = None) -> Lifecycle:
    """The life cycles of a run whose robots have all joined, by these `joins`."""
    robots = sum(len(join.robots) for join in joins)
    lifecycle = Lifecycle(robots, schedule or {}, Membership(), 0.0)
    for join in joins:
        assert lifecycle.hosting.join(join, 0.0).refusal == ""
    for robot in range(robots):
        lifecycle.token(robot, alive=True)
    lifecycle.begin_run(resumed=False)
    return lifecycle


def two() -> Lifecycle:
    return running(Join((0,), 1), Join((1,), 2))


def restart_session(lifecycle: Lifecycle, robot: int) -> None:
    """Lose the token of a robot, and see it again."""
    lifecycle.token(robot, alive=False)
    lifecycle.token(robot, alive=True)


def robots(number: int, *chosen: int) -> Bools:
    mask = np.zeros(number, dtype=np.bool_)
    mask[list(chosen)] = True
    return mask


def test_a_session_that_restarts_within_a_tick_costs_a_tick_and_its_robot_does_not_hang() -> None:
    """Messages to the old session are lost. A robot that was then excluded for its silence would get no others."""
    lifecycle = two()
    assert lifecycle.begin_tick(5, BOTH).tolist() == [True, True]
    restart_session(lifecycle, 1)
    assert lifecycle.reachable.tolist() == [True, False]
    assert lifecycle.silent(BOTH) == [0]
    assert lifecycle.begin_tick(5, BOTH).tolist() == [False, False]
    assert lifecycle.begin_tick(5, BOTH).tolist() == [False, True]
    assert lifecycle.message(0)
    assert lifecycle.begin_tick(5, BOTH).tolist() == [True, True]
    restart_session(lifecycle, 1)  # in the tick before it rejoins
    assert lifecycle.begin_tick(5, robots(2, 0)).tolist() == [True, True]


def test_a_robot_with_a_new_process_and_an_uninterrupted_token_misses_one_tick() -> None:
    """For example an agent that replaced another while the world was away: it starts without state."""
    for continuing, takes_part in ((BOTH, False), (robots(2, 0), True)):  # a robot that rejoins anyhow misses nothing
        hosts = {robot: Join((robot,), robot) for robot in (0, 1)}
        lifecycle = Lifecycle(2, {}, Membership(hosts, renewed=[1]), 0.0)
        for robot in (0, 1):
            lifecycle.token(robot, alive=True)
        lifecycle.begin_run(resumed=True)
        assert lifecycle.begin_tick(5, continuing).tolist() == [True, takes_part]
        assert not lifecycle.facts(1).is_renewed
        assert lifecycle.begin_tick(6, continuing).tolist() == [True, True]


def test_a_session_of_several_robots_that_restarts_within_a_tick_costs_all_of_them_that_tick() -> None:
    lifecycle = running(Join((0, 1), 1), Join((2,), 2))
    restart_session(lifecycle, 1)
    assert lifecycle.reachable.tolist() == [False, False, True]
    assert lifecycle.begin_tick(5, robots(3, 0, 1, 2)).tolist() == [False, False, True]
    assert lifecycle.begin_tick(6, robots(3, 2)).tolist() == [True, True, True]


def test_a_token_that_is_lost_before_the_run_begins_costs_nothing() -> None:
    lifecycle = Lifecycle(1, {}, Membership({0: Join((0,), 1)}), 0.0)
    lifecycle.token(0, alive=True)
    restart_session(lifecycle, 0)
    assert lifecycle.reachable.tolist() == [True]


def test_a_robot_that_hangs_by_schedule_is_suspended_only_in_a_process_of_its_own() -> None:
    none = robots(3)
    schedule = {
        2: ParticipationChange(robots(3, 0, 2), none, robots(3, 0, 2)),
        4: ParticipationChange(none, robots(3, 0, 2), none),
    }
    lifecycle = running(Join((0, 1), 1), Join((2,), 2), schedule=schedule)
    everybody = robots(3, 0, 1, 2)
    assert lifecycle.begin_tick(1, everybody).all()
    assert lifecycle.begin_tick(2, everybody).tolist() == [False, True, False]
    assert lifecycle.reachable.tolist() == [True, True, False]  # robot 0 keeps up in its process
    assert lifecycle.expected(3).tolist() == [False, True, False]
    assert lifecycle.due(4) == []
    lifecycle.token(2, alive=False)
    assert lifecycle.due(4) == [2]
    lifecycle.hosting.exclude({2: "excluded at tick 3: it sent no beacon"})
    assert lifecycle.due(4) == []
    assert lifecycle.expected(4).tolist() == [True, True, False]


def test_a_tick_cannot_begin_while_no_robot_that_should_take_part_can() -> None:
    lifecycle = two()
    assert lifecycle.missing(0) == ""
    assert lifecycle.silent(BOTH) == [0, 1]
    assert lifecycle.missing(0) == "no robot is reachable"
    gone = {1: ParticipationChange(BOTH, ~BOTH, ~BOTH)}
    absent = running(Join((0,), 1), Join((1,), 2), schedule=gone)
    absent.silent(BOTH)
    assert absent.missing(0) == "no robot is reachable"
    assert absent.missing(1) == ""  # the schedule expects none
