"""The barrier of a tick: verdicts on commands, observations that are sent again, and robots that hang."""

import pickle
from dataclasses import dataclass, field
from itertools import product

import numpy as np
import pytest

from fes.arrays.types import Bools
from world.execution.barrier import ANSWER_TIMEOUT, RESEND_AFTER, Action, Barrier, Pace, Participants, Verdict

BOTH = np.array([True, True])
NOW = 100.0


def participants(tick: int, *present: bool, since: tuple[int, ...] = (0, 0)) -> Participants:
    return Participants(tick, np.array(present or (True, True)), np.array(since))


def begun(tick: int = 5) -> Barrier:
    barrier = Barrier(2)
    barrier.begin(participants(tick), NOW)
    return barrier


def test_a_tick_is_done_when_each_robot_that_takes_part_has_answered() -> None:
    barrier = begun()
    assert barrier.missing == 2
    assert [barrier.judge(5, robot, is_woken=False) for robot in (1, 0)] == [Verdict.ANSWER] * 2
    assert barrier.missing == 0
    barrier.begin(participants(6, False, True), NOW)
    assert barrier.missing == 1


def test_an_observation_is_sent_again_after_times_that_double_until_its_robot_hangs() -> None:
    barrier = begun()
    barrier.judge(5, 0, is_woken=False)
    deadlines = []
    while True:
        deadlines.append(barrier.deadline - NOW)
        assert barrier.check(barrier.deadline - 0.001, BOTH) == Action()
        action = barrier.check(barrier.deadline, BOTH)
        if action.silent is not None:
            break
        assert action.resend == (1,)
    assert deadlines == [0.5, 1.5, 3.5, 7.5, 10.0]  # 0.5 s, 1 s, 2 s, 4 s, and the rest of 10 s
    assert action.silent.tolist() == [False, True]
    assert barrier.missing == 0


def test_a_robot_that_is_lost_is_not_awaited_and_its_late_answer_is_not_an_error() -> None:
    barrier = begun()
    assert barrier.check(NOW, np.array([True, False])) == Action()
    assert barrier.missing == 1
    barrier.check(NOW, BOTH)  # its token is back
    assert barrier.missing == 1
    assert barrier.judge(5, 1, is_woken=False) is Verdict.UNAWAITED


def test_second_answers_to_observations_sent_again_in_consecutive_ticks_are_not_errors() -> None:
    """The robot pauses between its answers: the second one comes when the next observation was sent again."""
    barrier = Barrier(2)
    for tick in range(4):
        barrier.begin(participants(tick), NOW)
        assert barrier.judge(tick, 1, is_woken=False) is Verdict.ANSWER
        assert barrier.check(NOW + RESEND_AFTER, BOTH).resend == (0,)
        if tick > 0:
            assert barrier.judge(tick - 1, 0, is_woken=False) is Verdict.REPEATED
        assert barrier.judge(tick, 0, is_woken=False) is Verdict.ANSWER
        assert barrier.judge(tick, 0, is_woken=False) is Verdict.REPEATED
        assert barrier.judge(tick, 1, is_woken=False) is Verdict.SECOND
    assert barrier.judge(1, 0, is_woken=False) is Verdict.WRONG_TICK  # a third answer, without a request
    barrier.begin(participants(4), NOW)
    assert [barrier.judge(tick, 0, is_woken=False) for tick in (1, 2, 3)] == [
        Verdict.WRONG_TICK,
        Verdict.REPEATED,
        Verdict.REPEATED,
    ]


def test_late_answers_of_an_absent_robot_are_not_errors_but_those_of_the_future_are() -> None:
    barrier = Barrier(2)
    barrier.begin(participants(7, True, False), NOW)
    verdicts = [barrier.judge(tick, 1, is_woken=False) for tick in (3, 7, 8)]
    assert verdicts == [Verdict.ABSENT, Verdict.ABSENT, Verdict.WRONG_TICK]
    barrier.begin(participants(8, since=(0, 8)), NOW)
    verdicts = [barrier.judge(tick, 1, is_woken=False) for tick in (7, 9, 8)]
    assert verdicts == [Verdict.ABSENT, Verdict.WRONG_TICK, Verdict.ANSWER]


def test_no_answer_is_awaited_before_a_tick_begins() -> None:
    barrier = begun()
    barrier.judge(5, 0, is_woken=False)
    barrier.rest(participants(6))
    assert barrier.missing == 0
    verdicts = [barrier.judge(tick, 0, is_woken=False) for tick in (6, 5, 7)]
    assert verdicts == [Verdict.UNAWAITED, Verdict.WRONG_TICK, Verdict.WRONG_TICK]


def test_a_paced_tick_ends_when_it_is_due_and_a_late_one_shortens_those_that_follow() -> None:
    pace, now, rests = Pace(0.02), NOW, []
    for longer in (0.0, 0.03, 0.0, 0.0, 0.0):  # the second sleep takes 30 ms more than requested
        pace.begin(now)
        rests.append(pace.rest(now))
        now += rests[-1] + longer
    assert rests == pytest.approx([0.02, 0.02, 0.0, 0.01, 0.02])
    assert now == pytest.approx(NOW + 0.1)  # five ticks, the last one of full length


def test_a_tick_without_a_pace_does_not_rest() -> None:
    pace = Pace(None)
    pace.begin(NOW)
    assert pace.rest(NOW) == 0.0


EVENTS = ("before", "now", "after", "second robot", "woken", "lost", "back", "resend", "time out", "next", "rejoin")
"""Commands of robot 0 for the tick before, this one and the next; a command of robot 1, and of robot 0 as it wakes;
the token of robot 1; time that passes; a tick with the robots that answered, and one with both."""

PREFIXES = [(), ("resend", "now", "second robot", "next", "resend")]
"""Events before: none, or a tick whose observations were sent again, and the next one."""

DEPTH = 4


@dataclass
class Witness:
    """The rules of the barrier in sets of robots and (robot, tick) pairs, without arrays, times and deadlines."""

    tick: int = 5
    since: dict[int, int] = field(default_factory=lambda: {0: 0, 1: 0})
    present: set[int] = field(default_factory=lambda: {0, 1})
    awaited: set[int] = field(default_factory=lambda: {0, 1})
    answered: set[int] = field(default_factory=set)
    reachable: set[int] = field(default_factory=lambda: {0, 1})
    resent: dict[int, list[int]] = field(default_factory=lambda: {0: [], 1: []})
    """Robot -> the ticks whose observations were sent again."""

    def verdict(self, robot: int, tick: int) -> Verdict:
        is_resent = tick in self.resent[robot][-2:]
        if robot not in self.present or tick < self.since[robot]:
            if tick <= self.tick:
                return Verdict.REPEATED if is_resent and tick < self.tick else Verdict.ABSENT
            return Verdict.WRONG_TICK
        if tick != self.tick:
            return Verdict.REPEATED if is_resent and tick < self.tick else Verdict.WRONG_TICK
        if robot in self.awaited:
            self.awaited.remove(robot)
            self.answered.add(robot)
            return Verdict.ANSWER
        if robot not in self.answered:
            return Verdict.UNAWAITED
        return Verdict.REPEATED if is_resent else Verdict.SECOND

    def resend(self) -> None:
        for robot in self.awaited:
            self.resent[robot] = [tick for tick in self.resent[robot] if tick != self.tick] + [self.tick]

    def next(self, present: set[int]) -> Participants:
        self.tick += 1
        self.since |= dict.fromkeys(present - self.answered, self.tick)
        self.present, self.awaited, self.answered = present, set(present), set()
        since = np.array([self.since[robot] for robot in (0, 1)])
        return Participants(self.tick, mask(present), since)


def mask(robots: set[int]) -> Bools:
    return np.array([robot in robots for robot in (0, 1)])


def follow(barrier: Barrier, witness: Witness, event: str) -> None:
    """Let an event happen to both, and compare all results."""
    match event:
        case "before" | "now" | "after":
            tick = witness.tick + {"before": -1, "now": 0, "after": 1}[event]
            assert barrier.judge(tick, 0, is_woken=False) is witness.verdict(0, tick)
        case "second robot":
            assert barrier.judge(witness.tick, 1, is_woken=False) is witness.verdict(1, witness.tick)
        case "woken":
            assert barrier.judge(witness.tick, 0, is_woken=True) is Verdict.WOKEN
        case "lost" | "back":
            witness.reachable = {0} if event == "lost" else {0, 1}
            witness.awaited &= witness.reachable
            assert barrier.check(NOW, mask(witness.reachable)) == Action()
        case "resend":
            witness.awaited &= witness.reachable
            is_last = barrier.deadline == NOW + ANSWER_TIMEOUT
            action = barrier.check(barrier.deadline, mask(witness.reachable))
            assert set(action.resend) == (set() if is_last else witness.awaited)
            if is_last:
                witness.awaited = set()
            witness.resend()
        case "time out":
            witness.awaited &= witness.reachable
            action = barrier.check(NOW + ANSWER_TIMEOUT, mask(witness.reachable))
            silent = set() if action.silent is None else set(np.flatnonzero(action.silent).tolist())
            assert (silent, action.resend) == (witness.awaited, ())
            witness.awaited = set()
        case "next" | "rejoin":
            present = set(witness.answered) if event == "next" else {0, 1}
            barrier.begin(witness.next(present), NOW)
    assert barrier.missing == len(witness.awaited)


@pytest.mark.parametrize("prefix", PREFIXES, ids=["at first", "after observations were sent again"])
def test_every_sequence_of_events_has_the_verdicts_and_actions_of_the_rules(prefix: tuple[str, ...]) -> None:
    first = begun(), Witness()
    for event in prefix:
        follow(*first, event)
    stored, count = [pickle.dumps(first)], 0
    for _ in range(DEPTH):
        before, stored = stored, []
        for state, event in product(before, EVENTS):
            barrier, witness = pickle.loads(state)
            follow(barrier, witness, event)
            stored.append(pickle.dumps((barrier, witness)))
            count += 1
    assert len(stored) == len(EVENTS) ** DEPTH == 14_641
    assert count == 16_104
