"""The barrier of a tick in lockstep: the answers that the world waits for, and what it does while it waits.

A pure state machine: commands, reachable robots and the time are arguments; verdicts and actions are values. It reads
no clock, sends nothing and logs nothing. One barrier serves all ticks, because a second answer may come a tick later.

    begin    a tick begins: each robot that takes part owes an answer
    judge    a command has come, and gets a verdict
    check    time has passed: observations to send again, and robots that hang
    rest     the tick is over, or has not begun: no answer is awaited
"""

from enum import Enum, auto
from typing import NamedTuple

import numpy as np

from fes.arrays.types import Bools, Ints

ANSWER_TIMEOUT = 10.0
"""A robot that does not answer a tick for this long [s] is hung, though its liveliness token may stay. It is excluded
until it sends a message again."""

RESEND_AFTER = 0.5
"""Time [s] after which an observation is sent again to robots that did not answer it. It doubles each time."""


class Participants(NamedTuple):
    """The robots that take part in a tick."""

    tick: int
    present: Bools
    """True for a robot that takes part [n]."""
    since: Ints
    """Tick at which each robot last joined [n]."""


class Verdict(Enum):
    """The meaning of a readable command to the barrier; only SECOND and WRONG_TICK are errors."""

    ANSWER = auto()
    """The answer that the robot owes."""
    REPEATED = auto()
    """A further answer to an observation that was sent again, just as its robot answered."""
    WOKEN = auto()
    """The first message of a hung robot, which takes part again from a later tick on."""
    ABSENT = auto()
    """An answer to a tick in which the robot took no part, or before it rejoined: the world did not wait for it."""
    UNAWAITED = auto()
    """An answer to this tick while none is awaited: the tick has not begun, or its robot was lost since."""
    SECOND = auto()
    """A second answer to an observation that was sent once."""
    WRONG_TICK = auto()
    """A command for another tick."""


class Action(NamedTuple):
    """Tasks of the world when time has passed."""

    resend: tuple[int, ...] = ()
    """Robots to send their observations of this tick again."""
    silent: Bools | None = None
    """Robots that did not answer in time [n]; the tick ends without them. None while time is left."""


class Barrier:
    """The answers of one tick after another."""

    def __init__(self, robots: int) -> None:
        self.missing = 0
        """Number of answers that are awaited; the tick is done when it is 0."""
        self.deadline = 0.0
        """Time at which `check` must follow [s], if an answer is missing until then."""
        self._begun = self._patience = 0.0
        self._resent: dict[int, tuple[int, ...]] = {}
        """Robot -> the last two ticks whose observations were sent again: a second answer may come a tick later."""
        self.rest(Participants(0, np.zeros(robots, dtype=np.bool_), np.zeros(robots, dtype=np.int64)))

    def rest(self, participants: Participants) -> None:
        """Await no answer: the tick of the `participants` has not begun."""
        self._now = participants
        self._pending: Bools = np.zeros(len(participants.present), dtype=np.bool_)
        """Robots whose answers are missing [n]."""
        self._answered: Bools = self._pending.copy()
        self.missing = 0

    def begin(self, participants: Participants, now: float) -> None:
        """Await an answer of each robot that takes part; all of them were sent their observations at `now` [s]."""
        self.rest(participants)
        self._pending = participants.present.copy()
        self.missing = int(np.count_nonzero(self._pending))
        self._begun, self._patience = now, RESEND_AFTER
        self.deadline = now + RESEND_AFTER

    def judge(self, tick: int, robot: int, is_woken: bool) -> Verdict:
        """The verdict on the command of a robot for a tick; `is_woken` if the robot was hung until this message."""
        if is_woken:
            return Verdict.WOKEN
        now, may_repeat = self._now, tick in self._resent.get(robot, ())
        if tick < now.tick and may_repeat:
            return Verdict.REPEATED
        if tick < now.since[robot] or (tick <= now.tick and not now.present[robot]):
            return Verdict.ABSENT
        if tick != now.tick:
            return Verdict.WRONG_TICK
        if self._pending[robot]:
            self._pending[robot], self._answered[robot] = False, True
            self.missing -= 1
            return Verdict.ANSWER
        if self._answered[robot]:
            return Verdict.REPEATED if may_repeat else Verdict.SECOND
        return Verdict.UNAWAITED

    def check(self, now: float, reachable: Bools) -> Action:
        """The tasks of the world at `now` [s]. Robots that are not `reachable` [n] cannot answer any more."""
        self._pending &= reachable
        self.missing = int(self._pending.sum())
        if not self.missing or now < self.deadline:
            return Action()
        if now >= self._begun + ANSWER_TIMEOUT:
            silent, self._pending, self.missing = self._pending, np.zeros_like(reachable), 0
            return Action(silent=silent)
        robots = tuple(np.flatnonzero(self._pending).tolist())
        for robot in robots:
            before = [tick for tick in self._resent.get(robot, ()) if tick != self._now.tick]
            self._resent[robot] = (*before[-1:], self._now.tick)
        self._patience *= 2.0
        self.deadline = min(now + self._patience, self._begun + ANSWER_TIMEOUT)
        return Action(robots)


class Pace:
    """The end of each tick in lockstep: after a late tick the next ones are shorter."""

    def __init__(self, period: float | None) -> None:
        """`period` is the average wall-clock time per tick [s]; None for full speed."""
        self._period = period
        self._due: float | None = None
        """End of the present tick [s]."""

    def begin(self, now: float) -> None:
        """A tick begins at `now` [s]."""
        if self._due is None:
            self._due = now

    def rest(self, now: float) -> float:
        """The time that remains of the tick whose answers are complete at `now` [s]."""
        if self._period is None or self._due is None:
            return 0.0
        self._due += self._period
        return max(0.0, self._due - now)
