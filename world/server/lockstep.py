"""The lockstep: each tick waits for the commands of all robots that take part."""

import asyncio
import logging
import time
from collections.abc import Callable, Sequence

import numpy as np

from fes.arrays.types import Bools
from fes.errors import MessageError, Unavailable
from fes.protocol import keys
from fes.protocol.messages import Command
from fes.transport.drop_log import DropLog
from fes.transport.inbox import Inbox, Item
from world.execution import marshalling
from world.execution.barrier import Barrier, Pace, Verdict
from world.execution.lifecycle import Lifecycle
from world.execution.run import Answer
from world.server import participation
from world.simulation.core import message_reader
from world.simulation.truth import State

RETURN_TIMEOUT = 60.0
"""The world waits this long [s] for any robot to take part, and for a robot that its scenario restarts or wakes."""


class Lockstep:
    """The barrier of each tick, and its pace, on the bus and the wall clock."""

    def __init__(
        self,
        inbox: Inbox,
        lifecycle: Lifecycle,
        drops: DropLog,
        observe: Sequence[Callable[[bytes], None]],
        pace: float | None = None,
    ) -> None:
        """`observe` holds, by robot, the function that publishes its observation.

        `pace` is the average wall-clock time per tick [s]: after a late tick the next ones are shorter. None: full
        speed."""
        self._inbox, self._lifecycle = inbox, lifecycle
        self._drops = drops
        self._reader = message_reader.of(lifecycle.robots)
        self._observe = observe
        self._barrier, self._pace = Barrier(lifecycle.robots), Pace(pace)
        self._logger = logging.getLogger("world")

    async def present(self, state: State) -> Bools:
        """The robots that take part at the tick of `state` [n]: at least one, unless none is expected.

        Raises Unavailable after RETURN_TIMEOUT. The world waits equally long for a robot that its scenario restarts
        or wakes, and then continues without it.
        """
        end, lifecycle = time.monotonic() + RETURN_TIMEOUT, self._lifecycle
        while (missing := lifecycle.missing(state.tick)) or (due := lifecycle.due(state.tick)):
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
            self._barrier.rest(participation.participants(state))
            for key, payload in self._inbox.drain():
                self._read(state, key, payload)  # a hung robot that sends a message can take part again
        return participation.begin_tick(lifecycle, state)

    async def collect(self, state: State, sent: list[bytes]) -> tuple[list[Answer | None], Bools]:
        """Each robot's answer at the end of the tick, in id order, and the robots that take part from now on [n].

        A robot that is lost or does not answer in time takes no part from this tick on: its answer is None.
        """
        answers: list[Answer | None] = [None] * len(sent)
        barrier, begun = self._barrier, time.monotonic()
        barrier.begin(participation.participants(state), begun)
        self._pace.begin(begun)
        awaited = barrier.missing
        while barrier.missing:
            # The inbox only counts messages, so junk may end the wait too: each pass checks the time.
            await self._inbox.wait(barrier.missing, max(0.0, barrier.deadline - time.monotonic()))
            items = self._inbox.drain()
            for (key, payload), usual in zip(items, self._usual(state.tick, items), strict=True):
                command = self._read(state, key, payload, usual)
                if command is not None and payload is not None:
                    answers[command.robot] = command, payload
            if barrier.missing:
                action = barrier.check(time.monotonic(), self._lifecycle.reachable)
                for robot in action.resend:
                    self._observe[robot](sent[robot])
                if action.silent is not None:
                    participation.hang(self._lifecycle, action.silent)
        rest = self._pace.rest(time.monotonic())
        if rest or not awaited:  # the loop must run even if no robot takes part
            await asyncio.sleep(rest)
        return answers, state.present & np.array([answer is not None for answer in answers])

    def _usual(self, tick: int, items: list[Item]) -> Sequence[Command | None]:
        """The commands for `tick` in messages, read together; None for each if one of them is unusual."""
        senders = [robot for key, _ in items if (robot := keys.robot_of(key)) is not None]
        payloads = [payload for _, payload in items if payload is not None]
        commands = None
        if self._reader is not None and len(senders) == len(payloads) == len(items):
            commands = self._reader.commands(tick, senders, payloads)
        return [None] * len(items) if commands is None else commands

    def _read(self, state: State, key: str, payload: bytes | None, usual: Command | None = None) -> Command | None:
        """The command in a message if it is an answer that is awaited; errors are dropped and counted.

        `usual` is the command if it was read already.
        """
        try:
            command = usual or marshalling.decode(key, payload, len(state.present))
            verdict = self._barrier.judge(command.tick, command.robot, self._lifecycle.message(command.robot))
            if verdict is Verdict.WRONG_TICK:
                raise MessageError("Command", "is not for this tick", str(command.tick))
        except MessageError as error:
            self._drops.unread(key, error)
            return None
        if verdict is Verdict.SECOND:
            self._drops.reject("Command: came twice", f"{key}: a second command for tick {command.tick}")
        return command if verdict is Verdict.ANSWER else None
