"""The lockstep: each tick waits for the commands of all robots that take part."""

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
"""A robot that does not answer a tick for this long [s] is hung, though its liveliness token may stay. It is excluded
until it sends a message again."""

RETURN_TIMEOUT = 60.0
"""The world waits this long [s] for any robot to take part, and for a robot that its scenario restarts or wakes."""

RESEND_AFTER = 0.5
"""Time [s] after which an observation is sent again to robots that did not answer it. It doubles each time."""

Send = Callable[[int, bytes], None]
"""Send a robot its observation."""


class Lockstep:
    """The barrier of each tick, and its pace."""

    def __init__(
        self, inbox: Inbox, participation: Participation, drops: DropLog, send: Send, pace: float | None = None
    ) -> None:
        """`pace` is the average wall-clock time per tick [s]: after a late tick the next ones are shorter. None: full
        speed."""
        self._inbox, self._participation = inbox, participation
        self._drops = drops
        self._send = send
        self._pace = pace
        self._due = 0.0  # end of the present tick [s; monotonic]
        self._logger = logging.getLogger("world")
        self._resent: dict[int, tuple[int, ...]] = {}
        """Robot -> the last two ticks whose observations were sent again: a second answer may come a tick later."""

    async def present(self, state: State) -> Bools:
        """The robots that take part at the tick of `state` [n]: at least one, unless none is expected.

        Raises Unavailable after RETURN_TIMEOUT. The world waits equally long for a robot that its scenario restarts
        or wakes, and then continues without it.
        """
        end = time.monotonic() + RETURN_TIMEOUT
        while (missing := self._participation.missing(state)) or (due := self._participation.due(state)):
            left = end - time.monotonic()
            if left <= 0.0 and missing:
                raise Unavailable(f"{missing}: the world waited {RETURN_TIMEOUT:g} s at tick {state.tick}")
            if left <= 0.0:
                self._logger.warning(
                    "robots %s are due at tick %d and did not join within %g s: the run continues without them",
                    due,
                    state.tick,
                    RETURN_TIMEOUT,
                )
                break
            await self._inbox.wait(1, left)
            for key, payload in self._inbox.drain():
                self._read(state, key, payload)  # a hung robot that sends a message can take part again
        return self._participation.participating(state)

    async def collect(self, state: State, sent: list[bytes]) -> tuple[list[Answer | None], Bools]:
        """Each robot's answer at the end of the tick, in id order, and the robots that take part from now on [n].

        A robot that is lost or does not answer in time takes no part from this tick on: its answer is None.
        """
        answers: list[Answer | None] = [None] * len(sent)
        pending = state.present.copy()
        missing, begun, patience = int(pending.sum()), time.monotonic(), RESEND_AFTER
        self._due = self._due or begun
        resend_at = begun + patience
        while missing:
            # The inbox only counts messages, so junk may end the wait too: each pass checks the time.
            await self._inbox.wait(missing, max(0.0, resend_at - time.monotonic()))
            for key, payload in self._inbox.drain():
                command = self._read(state, key, payload)
                if command is not None and payload is not None and pending[command.robot]:
                    answers[command.robot] = command, payload
                    pending[command.robot] = False
                    missing -= 1
                elif command is not None and answers[command.robot] and not self._may_repeat(command):
                    self._drops.reject("Command: came twice", f"{key}: a second command for tick {command.tick}")
            if missing:
                pending &= self._participation.reachable
                missing = int(pending.sum())
            if missing and time.monotonic() >= resend_at:
                if time.monotonic() - begun >= ANSWER_TIMEOUT:
                    self._participation.hang(pending)
                    break
                for robot in np.flatnonzero(pending).tolist():
                    self._send(robot, sent[robot])
                    before = [tick for tick in self._resent.get(robot, ()) if tick != state.tick]
                    self._resent[robot] = (*before[-1:], state.tick)
                patience *= 2.0
                resend_at = min(time.monotonic() + patience, begun + ANSWER_TIMEOUT)
        await self._end_of_tick()
        return answers, state.present & np.array([answer is not None for answer in answers])

    async def _end_of_tick(self) -> None:
        """Wait until the tick is due, and let the event loop run even if no robot takes part."""
        self._due += self._pace or 0.0
        await asyncio.sleep(max(0.0, self._due - time.monotonic()) if self._pace is not None else 0.0)

    def _may_repeat(self, command: Command) -> bool:
        """True if the observation of this command was sent again, so that its robot may answer twice."""
        return command.tick in self._resent.get(command.robot, ())

    def _read(self, state: State, key: str, payload: bytes | None) -> Command | None:
        """The command in a message if it is for this tick; other messages are dropped and counted.

        The world does not wait for a robot that takes no part, so its last answers may come after it rejoined. A
        duplicate answer is not an error if its observation was sent again just as the robot answered.
        """
        try:
            command = marshalling.decode(key, payload, len(state.present))
            duplicate = command.tick < state.tick and self._may_repeat(command)
            absent = command.tick < state.since[command.robot] or (
                not state.present[command.robot] and command.tick <= state.tick
            )
            if self._participation.wake(command.robot) or duplicate or absent:
                return None
            if command.tick != state.tick:
                raise MessageError("Command", "is not for this tick", str(command.tick))
        except MessageError as error:
            self._drops.unread(key, error)
            return None
        return command
