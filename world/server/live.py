"""The live clock: ticks are due at times of the wall clock, and wait for no robot.

At the end of a tick each robot's body follows its last command. A robot whose last command is too old stops. If the
world itself is late, its clock slips: each tick has its full length, and none is skipped.
"""

import asyncio
import time

from fes.arrays.types import Bools
from fes.errors import MessageError
from fes.protocol.messages import Command
from fes.transport.drop_log import DropLog
from fes.transport.inbox import Inbox
from world.execution import marshalling
from world.execution.lifecycle import Lifecycle
from world.execution.live_tick import LivePace, LiveTick, Timing
from world.execution.run import Answer
from world.metrics.deadlines import Deadlines
from world.server import participation
from world.server.lockstep import Lockstep
from world.simulation.truth import State

WARM_UP = 25
"""The first ticks of a run, and those after a world resumed it, are in lockstep. In these ticks contacts open,
subscriptions are declared, and all code runs for the first time."""


class LiveClock:
    """The end of each tick, and the last command of each robot, on the bus and the wall clock."""

    def __init__(
        self,
        warm_up: Lockstep,
        inbox: Inbox,
        lifecycle: Lifecycle,
        drops: DropLog,
        deadlines: Deadlines,
        dt: float,
    ) -> None:
        """`warm_up` collects the first WARM_UP ticks."""
        self._warm_up, self._left = warm_up, WARM_UP
        self._inbox, self._lifecycle = inbox, lifecycle
        self._drops, self._deadlines = drops, deadlines
        self._tick, self._pace = LiveTick(len(deadlines.due), dt), LivePace(dt)
        self._last: dict[int, Answer] = {}
        """Robot -> its newest answer."""

    async def present(self, state: State) -> Bools:
        """The robots that take part at the tick of `state` [n]: those that are reachable now."""
        return participation.begin_tick(self._lifecycle, state)

    async def collect(self, state: State, sent: list[bytes]) -> tuple[list[Answer | None], Bools]:
        """The answer that each robot follows at the end of this tick, and the robots that take part from now on [n].

        Answers are in id order. A robot whose answer is None stops.
        """
        if self._left:
            self._left -= 1
            answers, present = await self._warm_up.collect(state, sent)
            for answer in answers:
                if answer is not None:
                    self._store(state, *answer)
            return answers, present
        await asyncio.sleep(self._pace.rest(time.monotonic()))
        self._deadlines.slipped += self._pace.slip(time.monotonic())
        for key, payload in self._inbox.drain():
            self._read(state, key, payload)
        end = self._tick.end(participation.participants(state))
        if end.silent.any():
            participation.hang(self._lifecycle, end.silent)
        robots = enumerate(end.following.tolist())
        return [self._last[robot] if is_following else None for robot, is_following in robots], state.present

    def _store(self, state: State, command: Command, payload: bytes) -> Timing:
        """Store a command if it is the newest of its robot."""
        timing = self._tick.receive(command.tick, command.robot, state.tick)
        if timing in (Timing.IN_TIME, Timing.LATE):
            self._last[command.robot] = command, payload
        return timing

    def _read(self, state: State, key: str, payload: bytes | None) -> None:
        """Store the command in a message; errors are dropped and counted."""
        try:
            command = marshalling.decode(key, payload, len(state.present))
            timing = self._store(state, command, payload or b"")
            if timing is Timing.FUTURE:
                raise MessageError("Command", "is not for this tick", str(command.tick))
        except MessageError as error:
            self._drops.unread(key, error)
            return
        self._lifecycle.message(command.robot)
        self._deadlines.late[command.robot] += timing is Timing.LATE
