"""The lockstep: every tick waits for the commands of all robots that are there."""

import asyncio
import logging
import time
from collections.abc import Callable

import numpy as np

from fes.arrays.types import Bools
from fes.errors import MessageError, Unavailable
from fes.protocol.messages import Command
from fes.transport.drop_log import DropLog
from fes.transport.inbox import Inbox
from world.execution import marshalling
from world.execution.run import Answer
from world.server.participation import Participation
from world.simulation.truth import State

ANSWER_TIMEOUT = 10.0
"""A living robot that does not answer a tick for this long [s] is hung, for its liveliness token may stay: it is left
out until it speaks again."""

RETURN_TIMEOUT = 60.0
"""The world waits this long [s] for any robot to take part, and for a robot that its scenario brings back."""

ASK_AGAIN = 0.5
"""An observation is sent again to robots that did not answer it for this long [s], then for twice as long, ..."""

Ask = Callable[[int, bytes], None]
"""Send a robot its observation."""


class Lockstep:
    """The barrier of each tick, and its pace."""

    def __init__(
        self, inbox: Inbox, participation: Participation, drops: DropLog, ask: Ask, pace: float | None = None
    ) -> None:
        """`pace` is the wall-clock time of a tick [s], on average: who falls behind catches up. None: full speed."""
        self._inbox, self._attendance = inbox, participation
        self._complaints = drops
        self._ask = ask
        self._pace = pace
        self._due = 0.0  # end of the present tick [s; monotonic]
        self._logger = logging.getLogger("world")
        self._asked: dict[int, tuple[int, ...]] = {}
        """The last two ticks that each robot was asked for again: its second answer may come a tick later."""

    async def present(self, state: State) -> Bools:
        """The robots that take part at the tick of `state` [n]: at least one, unless none should.

        Raises Absent after RETURN_TIMEOUT. A robot that its scenario brings back is awaited as long, then missed.
        """
        end = time.monotonic() + RETURN_TIMEOUT
        while (missing := self._attendance.missing(state)) or (due := self._attendance.due(state)):
            left = end - time.monotonic()
            if left <= 0.0 and missing:
                raise Unavailable(f"{missing}: the world waited {RETURN_TIMEOUT:g} s at tick {state.tick}")
            if left <= 0.0:
                self._logger.warning(
                    "robots %s are due at tick %d and did not come within %g s: the run continues without them",
                    due,
                    state.tick,
                    RETURN_TIMEOUT,
                )
                break
            await self._inbox.wait(1, left)
            for key, payload in self._inbox.drain():
                self._read(state, key, payload)  # a hung robot that speaks again can take part again
        return self._attendance.now(state)

    async def collect(self, state: State, sent: list[bytes]) -> tuple[list[Answer | None], Bools]:
        """Every robot's command for this tick and its payload, in id order, and who takes part from now on [n], when
        the tick is over.

        A robot that is lost or does not answer in time is not there from this tick on: its command is None.
        """
        answers: list[Answer | None] = [None] * len(sent)
        waited = state.present.copy()
        missing, begun, patience = int(waited.sum()), time.monotonic(), ASK_AGAIN
        self._due = self._due or begun
        ask_at = begun + patience
        while missing:
            # Messages are only counted here, so junk may wake us too: time is looked at on every pass.
            await self._inbox.wait(missing, max(0.0, ask_at - time.monotonic()))
            for key, payload in self._inbox.drain():
                command = self._read(state, key, payload)
                if command is not None and payload is not None and waited[command.robot]:
                    answers[command.robot] = command, payload
                    waited[command.robot] = False
                    missing -= 1
                elif command is not None and answers[command.robot] and not self._twice(command):
                    self._complaints.reject("Command: came twice", f"{key}: a second command for tick {command.tick}")
            if missing:
                waited &= self._attendance.there
                missing = int(waited.sum())
            if missing and time.monotonic() >= ask_at:
                if time.monotonic() - begun >= ANSWER_TIMEOUT:
                    self._attendance.hang(waited)
                    break
                for robot in np.flatnonzero(waited).tolist():
                    self._ask(robot, sent[robot])
                    before = [tick for tick in self._asked.get(robot, ()) if tick != state.tick]
                    self._asked[robot] = (*before[-1:], state.tick)
                patience *= 2.0
                ask_at = min(time.monotonic() + patience, begun + ANSWER_TIMEOUT)
        await self._end_of_tick()
        return answers, state.present & np.array([answer is not None for answer in answers])

    async def _end_of_tick(self) -> None:
        """No tick is skipped, and none ends before the loop had its turn, though nobody takes part."""
        self._due += self._pace or 0.0
        await asyncio.sleep(max(0.0, self._due - time.monotonic()) if self._pace is not None else 0.0)

    def _twice(self, command: Command) -> bool:
        """Whether its robot was asked for this command again, so that it may come twice."""
        return command.tick in self._asked.get(command.robot, ())

    def _read(self, state: State, key: str, payload: bytes | None) -> Command | None:
        """The command in a message if it is one for this tick; anything else is dropped and counted.

        Nobody waits for the answers of a robot that takes no part, so its last ones may come when it does again. A
        second answer to an earlier tick is no fault of a robot that was asked again for it, just when it answered.
        """
        try:
            command = marshalling.decode(key, payload, len(state.present))
            asked = command.tick < state.tick and self._twice(command)
            absent = command.tick < state.since[command.robot] or (
                not state.present[command.robot] and command.tick <= state.tick
            )
            if self._attendance.woke(command.robot) or asked or absent:
                return None
            if command.tick != state.tick:
                raise MessageError("Command", "is not for this tick", str(command.tick))
        except MessageError as error:
            self._complaints.unread(key, error)
            return None
        return command
