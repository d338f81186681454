"""The live clock: ticks are due at times of the wall clock, and wait for no robot.

At the end of a tick each robot's body follows its last command. A robot whose last command is too old stops. If the
world itself is late, its clock slips: each tick has its full length, and none is skipped.
"""

import asyncio
import time

import numpy as np

from fes.arrays.types import Bools
from fes.errors import MessageError
from fes.transport.drop_log import DropLog
from fes.transport.inbox import Inbox
from world.execution import marshalling
from world.execution.run import Answer
from world.metrics.deadlines import COMMAND_TIMEOUT, Deadlines
from world.server.lockstep import Lockstep
from world.server.participation import Participation
from world.simulation.truth import State

WARM_UP = 25
"""The first ticks of a run, and those after a world resumed it, are in lockstep. In these ticks contacts open,
subscriptions are declared, and all code runs for the first time."""

HANG_TIMEOUT = 2.0
"""A robot that sends no command for this long [s] is excluded, though its token may stay. When it sends one again, it
rejoins and starts without state."""


class LiveClock:
    """The end of each tick, and the last command of each robot."""

    def __init__(
        self,
        warm_up: Lockstep,
        inbox: Inbox,
        participation: Participation,
        drops: DropLog,
        deadlines: Deadlines,
        dt: float,
    ) -> None:
        """`warm_up` collects the first WARM_UP ticks."""
        self._warm_up, self._left = warm_up, WARM_UP
        self._inbox, self._participation = inbox, participation
        self._drops, self._deadlines = drops, deadlines
        self._dt = dt
        self._last: dict[int, Answer] = {}
        """Robot -> its newest answer."""
        self._due = 0.0  # end of the present tick [s; monotonic]

    async def present(self, state: State) -> Bools:
        """The robots that take part at the tick of `state` [n]: those that are reachable now."""
        return self._participation.participating(state)

    async def collect(self, state: State, sent: list[bytes]) -> tuple[list[Answer | None], Bools]:
        """The answer that each robot follows at the end of this tick, and the robots that take part from now on [n].

        Answers are in id order. A robot whose answer is None stops.
        """
        if self._left:
            self._left -= 1
            answers, present = await self._warm_up.collect(state, sent)
            self._last.update((robot, answer) for robot, answer in enumerate(answers) if answer is not None)
            return answers, present
        await self._end_of_tick()
        for key, payload in self._inbox.drain():
            self._read(state, key, payload)
        answers = [None] * len(sent)
        silent = np.zeros(len(sent), dtype=np.bool_)
        for robot in np.flatnonzero(state.present).tolist():
            last, since = self._last.get(robot), int(state.since[robot])
            answered = last[0].tick if last is not None else -1
            if answered >= since and (state.tick - answered) * self._dt < COMMAND_TIMEOUT:
                answers[robot] = last
            silent[robot] = (state.tick - max(answered, since)) * self._dt >= HANG_TIMEOUT
        if silent.any():
            self._participation.hang(silent)
        return answers, state.present

    async def _end_of_tick(self) -> None:
        now = time.monotonic()
        if self._due == 0.0:
            self._due = now
        self._due += self._dt
        await asyncio.sleep(max(0.0, self._due - now))
        behind = time.monotonic() - self._due
        if behind > self._dt / 2.0:
            self._due += behind
            self._deadlines.slipped += behind

    def _read(self, state: State, key: str, payload: bytes | None) -> None:
        """Store a command if it is the newest of its robot."""
        try:
            command = marshalling.decode(key, payload, len(state.present))
            if command.tick > state.tick:
                raise MessageError("Command", "is not for this tick", str(command.tick))
        except MessageError as error:
            self._drops.unread(key, error)
            return
        self._participation.wake(command.robot)
        last = self._last.get(command.robot)
        if payload is not None and (last is None or command.tick > last[0].tick):
            self._last[command.robot] = command, payload
            self._deadlines.late[command.robot] += command.tick < state.tick
