"""The live clock: ticks are due at times of the wall clock, and wait for nobody.

At the end of a tick each robot's body does what it was told last. A command that is too old is no command: the robot
stops. If the world itself is late, its clock slips: robots are given a whole tick, and none is skipped.
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
"""The first ticks of a run, and those after a world came back, are in lockstep: contacts open, subscriptions are
made, and everything runs for the first time, on a machine that has just started eleven interpreters."""

HANG_TIMEOUT = 2.0
"""A living robot that says nothing for this long [s] is left out until it speaks again, and then begins anew."""


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
        """`warm_up` has the first ticks, WARM_UP of them."""
        self._warm_up, self._left = warm_up, WARM_UP
        self._inbox, self._attendance = inbox, participation
        self._complaints, self._deadlines = drops, deadlines
        self._dt = dt
        self._last: dict[int, Answer] = {}
        self._due = 0.0  # end of the present tick [s; monotonic]

    async def present(self, state: State) -> Bools:
        """Who takes part at the tick of `state` [n]: who is there now."""
        return self._attendance.now(state)

    async def collect(self, state: State, sent: list[bytes]) -> tuple[list[Answer | None], Bools]:
        """The command that each robot follows at the end of this tick and its payload, in id order, None to stop; and
        who takes part from now on [n].
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
            heard = last[0].tick if last is not None else -1
            if heard >= since and (state.tick - heard) * self._dt < COMMAND_TIMEOUT:
                answers[robot] = last
            silent[robot] = (state.tick - max(heard, since)) * self._dt >= HANG_TIMEOUT
        if silent.any():
            self._attendance.hang(silent)
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
        """Keep a command if it is the newest of its robot."""
        try:
            command = marshalling.decode(key, payload, len(state.present))
            if command.tick > state.tick:
                raise MessageError("Command", "is not for this tick", str(command.tick))
        except MessageError as error:
            self._complaints.unread(key, error)
            return
        self._attendance.woke(command.robot)
        last = self._last.get(command.robot)
        if payload is not None and (last is None or command.tick > last[0].tick):
            self._last[command.robot] = command, payload
            self._deadlines.late[command.robot] += command.tick < state.tick
