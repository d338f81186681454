"""The life cycles of two robots: each transition from each state that can be reached keeps the rules stated here."""

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
import pytest

from fes.protocol.messages import Join
from tests.support import lifecycles
from tests.support.lifecycles import FAULT, ROBOTS, Schedule, Transition
from world.config.events import ParticipationChange
from world.execution.hosting import LEASE, RESUME_TIMEOUT, Membership
from world.execution.lifecycle import Facts

ONE_PROCESS = (Join((0, 1), 1), Join((0, 1), 2))
TWO_PROCESSES = (Join((0,), 1), Join((1,), 2))
RIVALS = (*TWO_PROCESSES, Join((0,), 3))
MIXED = (Join((0, 1), 1), Join((1,), 2))
"""The second robot may get a process of its own, while the first still counts as sharing the old one."""

NONE, SECOND = np.array([False, False]), np.array([False, True])
HANG: Schedule = {1: ParticipationChange(SECOND, NONE, SECOND), 2: ParticipationChange(NONE, SECOND, NONE)}
Absent = frozenset[tuple[int, int]]
"""The (tick, robot) pairs at which a schedule has a robot hung."""


def group(facts: tuple[Facts, ...], robot: int) -> tuple[int, ...]:
    host = facts[robot].host
    return (robot,) if host is None else host.robots


def is_answering(fact: Facts) -> bool:
    return fact.is_hosted and not fact.is_hung and not fact.fault


def expected_refusal(facts: tuple[Facts, ...], join: Join) -> str:
    """The refusal of a Join, from the facts alone."""
    if all(facts[robot].host == join for robot in join.robots):
        return next((f"robot {robot} is {FAULT}" for robot in join.robots if facts[robot].fault), "")
    for robot in join.robots:
        fact = facts[robot]
        if fact.is_alive and fact.host is None:
            return f"robot {robot} is hosted by an agent of an earlier world"
        if fact.is_alive or fact.promised_until > 0.0:
            return f"robot {robot} is hosted by another agent already"
    return ""


def changed(step: Transition) -> dict[tuple[int, str], Any]:
    """(robot, field) -> the new value of each fact that an event changed."""
    return {
        (robot, field): getattr(step.after.facts[robot], field)
        for robot in range(ROBOTS)
        for field in Facts._fields
        if getattr(step.after.facts[robot], field) != getattr(step.before.facts[robot], field)
    }


def new_facts(step: Transition, robots: Any, **values: Any) -> dict[tuple[int, str], Any]:
    """The facts of `robots` among `values` that differ from those before an event."""
    before = step.before.facts
    items = {(robot, field): value for robot in robots for field, value in values.items()}
    return {
        (robot, field): value for (robot, field), value in items.items() if getattr(before[robot], field) != value
    }


def check_state(step: Transition) -> None:
    """A robot is hosted while all robots of its process are alive, and reachable unless a fact prevents it."""
    facts, lifecycle = step.after.facts, step.after.lifecycle
    for robot, fact in enumerate(facts):
        is_complete = all(facts[member].is_alive for member in group(facts, robot))
        assert fact.is_hosted == (fact.host is not None and is_complete)
        can_answer = is_answering(fact) and not fact.is_suspended and not fact.is_disconnected
        assert bool(lifecycle.reachable[robot]) == can_answer
    if facts[0].host is not None and facts[0].host == facts[1].host:
        assert facts[0].is_hosted == facts[1].is_hosted
    assert (lifecycle.missing(step.after.tick) != "") == (not any(map(is_answering, facts)))


def check_lease(step: Transition) -> None:
    facts, robot = step.before.facts, step.result
    free = [r for r, fact in enumerate(facts) if not (fact.is_alive or fact.promised_until or fact.leased_until)]
    assert robot == (free[0] if free else None)
    assert changed(step) == ({} if robot is None else {(robot, "leased_until"): LEASE})


def check_join(step: Transition) -> None:
    join, before = step.event.argument, step.before.facts
    refusal = expected_refusal(before, join)
    is_known = all(before[robot].host == join for robot in join.robots)
    assert step.result == (refusal, is_known)
    if refusal:
        assert changed(step) == {}
    elif is_known:
        assert changed(step) == new_facts(step, join.robots, promised_until=LEASE)
    else:
        assert not any(before[robot].is_alive for robot in join.robots)
        values = {"host": join, "is_renewed": True, "fault": "", "promised_until": LEASE}
        assert changed(step) == new_facts(step, join.robots, **values)


def check_token(step: Transition) -> None:
    (robot, alive), before = step.event.argument, step.before.facts
    wanted = new_facts(step, [robot], is_alive=alive, promised_until=0.0)
    if step.before.is_running and not alive:  # messages to the whole process are lost, and its next one is not hung
        wanted |= new_facts(step, group(before, robot), is_disconnected=True, is_hung=False)
    assert {fact: value for fact, value in changed(step).items() if fact[1] != "is_hosted"} == wanted


def check_silent(step: Transition) -> None:
    before = step.before.facts
    silent = [robot for robot in range(ROBOTS) if step.event.argument[robot]]
    hung = [robot for robot in silent if before[robot].is_alive and not before[robot].is_disconnected]
    assert step.result == hung
    members = {member for robot in hung for member in group(before, robot)}
    assert changed(step) == new_facts(step, members, is_hung=True)


def check_message(step: Transition) -> None:
    robot, before = step.event.argument, step.before.facts
    assert step.result == before[robot].is_hung
    assert changed(step) == (new_facts(step, group(before, robot), is_hung=False) if step.result else {})


def check_exclude(step: Transition) -> None:
    robots = group(step.before.facts, step.event.argument)
    assert changed(step) == new_facts(step, robots, fault=FAULT)


def check_wait(step: Transition) -> None:
    assert {field for _, field in changed(step)} <= {"promised_until", "leased_until"}


def check_begin_run(step: Transition) -> None:
    assert changed(step) == new_facts(step, range(ROBOTS), is_renewed=False)


def check_begin_tick(step: Transition, absent: Absent) -> None:
    before, wanted = step.before.facts, dict[tuple[int, str], Any]()
    for robot, fact in enumerate(before):
        continues, is_absent = step.before.continuing[robot], (step.before.tick, robot) in absent
        is_able = is_answering(fact) and not (fact.is_disconnected and continues)
        assert step.result[robot] == (is_able and not is_absent and not (fact.is_renewed and continues))
        is_suspended = is_absent and len(group(before, robot)) == 1
        is_renewed = fact.is_renewed and not is_able
        wanted |= new_facts(step, [robot], is_disconnected=False, is_suspended=is_suspended, is_renewed=is_renewed)
    assert changed(step) == wanted


CHECKS: dict[str, Callable[[Transition], None]] = {
    "lease": check_lease,
    "join": check_join,
    "token": check_token,
    "silent": check_silent,
    "message": check_message,
    "exclude": check_exclude,
    "wait": check_wait,
    "begin_run": check_begin_run,
}


def check_together(step: Transition) -> None:
    """Robots that never had another process hang, leave and are excluded together."""
    first, second = step.after.facts
    if first.host is None:
        return
    assert (first.is_hosted, first.is_hung) == (second.is_hosted, second.is_hung)
    assert (first.is_disconnected, first.fault) == (second.is_disconnected, second.fault)


def check_all(
    steps: Iterable[Transition], absent: Absent = frozenset(), share_process: bool = False
) -> tuple[int, int, set[str]]:
    """Check each transition; returns the numbers of states and transitions, and the kinds of events that occurred."""
    count, states, kinds = 0, set[Any](), set[str]()
    for step in steps:
        kind = step.event.kind
        if kind == "begin_tick":
            check_begin_tick(step, absent)
        else:
            CHECKS[kind](step)
        state = lifecycles.key(step.after)
        if state not in states:
            check_state(step)
            if share_process:
                check_together(step)
            states.add(state)
        count += 1
        kinds.add(kind)
    return len(states), count, kinds


@pytest.mark.parametrize(
    ("joins", "states", "transitions"),
    [(ONE_PROCESS, 320, 3_200), (TWO_PROCESSES, 576, 5_760), (RIVALS, 960, 10_560), (MIXED, 576, 5_760)],
    ids=["one process", "two processes", "a rival", "one, then two"],
)
def test_agents_get_robots_that_are_free_and_no_others(
    joins: tuple[Join, ...], states: int, transitions: int
) -> None:
    """Leases, joins, tokens and faults, as time passes."""
    visited = check_all(lifecycles.explore(lifecycles.start({}), lifecycles.hosting_events(joins)))
    assert visited == (states, transitions, {"lease", "join", "token", "exclude", "wait"})


@pytest.mark.parametrize(
    ("joins", "schedule", "states", "transitions"),
    [
        (ONE_PROCESS, HANG, 2_400, 33_000),
        (TWO_PROCESSES, HANG, 3_000, 42_000),
        (RIVALS, {}, 4_000, 60_000),
        (MIXED, {}, 3_200, 44_000),
    ],
    ids=[
        "one process, in which a robot hangs by schedule",
        "two processes, one of which hangs by schedule",
        "a rival",
        "one, then two",
    ],
)
def test_robots_that_can_answer_take_part_and_no_others(
    joins: tuple[Join, ...], schedule: Schedule, states: int, transitions: int
) -> None:
    """Joins, tokens, silence, messages, faults and ticks, in any order."""
    steps = lifecycles.explore(
        lifecycles.start(schedule), lifecycles.all_events(joins), last_tick=2 if schedule else 0
    )
    absent = frozenset({(1, 1)}) if schedule else frozenset()
    visited, count, kinds = check_all(steps, absent, share_process=joins == ONE_PROCESS)
    assert visited >= states
    assert count >= transitions
    assert kinds == CHECKS.keys() - {"lease", "wait"} | {"begin_tick"}


def test_a_resumed_world_leases_its_robots_to_no_other_agent_for_a_while() -> None:
    """All transitions from a world that resumes a run, whose agents hosted both robots."""
    first = lifecycles.start({}, Membership(dict(enumerate(TWO_PROCESSES)), renewed=[0]))
    leased = set[int]()
    for step in lifecycles.explore(first, lifecycles.hosting_events(TWO_PROCESSES)):
        CHECKS[step.event.kind](step)
        check_state(step)
        if step.event.kind == "lease" and step.result is not None:
            leased.add(step.result)
            assert step.before.now >= RESUME_TIMEOUT
    assert leased == {0, 1}
