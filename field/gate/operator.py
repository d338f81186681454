"""The operator's side of a gate: it takes permits, answers starts, stops and states, and has a liveliness token.

An answer waits while the operator's network is congested. So a thread sends it, and the loop never waits.
"""

import asyncio
import logging
import threading
from collections.abc import Callable
from functools import partial
from queue import SimpleQueue

from fes.errors import FesError, MessageError, Rejected
from fes.protocol import keys
from fes.protocol.robot_control import GateStatus, Permit, decode_permit, encode_gate_status
from fes.transport.bus import Bus, Query
from field.gate.driver import Arrivals

TRIES, PAUSE, PATIENCE = 12, 0.25, 2.0
"""Tries, 0.25 s apart, to be the only gate: after a cut of its link, the token of an earlier gate stays for 2 s."""

SCHEMA = "fes.GateStatus"

MOST_ANSWERS = 64
"""Answers that wait to be sent; with as many, further queries are refused, but for stops."""

MOST_WITH_STOPS = 2 * MOST_ANSWERS
"""As MOST_ANSWERS, for stops: unread answers to other queries must not keep a robot from its stop."""

Control = Callable[[bytes], GateStatus]
"""Answers a query, given its payload, with the state afterwards; raises FesError to reject it."""


class Answers:
    """Answers on their way from the loop to the network, which a thread sends in order.

    The thread ends with the process. Nothing waits for it, since Zenoh may block it for seconds.
    """

    def __init__(self) -> None:
        self._waiting: SimpleQueue[Callable[[], None]] = SimpleQueue()
        threading.Thread(target=self._send, name="answers", daemon=True).start()

    def has_room(self, most: int = MOST_ANSWERS) -> bool:
        """True if fewer than `most` answers wait."""
        return self._waiting.qsize() < most

    def put(self, send: Callable[[], None]) -> None:
        """Let the thread call `send`."""
        self._waiting.put(send)

    def _send(self) -> None:
        while True:
            try:
                self._waiting.get()()
            except Exception as error:  # the session is closed, or its link is gone: the operator asks again
                logging.getLogger("gate").debug("an answer is lost: %s", error)


class Operator:
    """The keys of one robot's gate."""

    def __init__(self, bus: Bus, run: str, robot: int, wake: Callable[[], None]) -> None:
        self._bus = bus
        self._run = run
        self._robot = robot
        self._logger = logging.getLogger(f"gate.{robot}")
        self._permits = Arrivals(asyncio.get_running_loop(), wake)
        self._answers = Answers()
        self._has_complained = False

    async def claim(self) -> None:
        """Check that no other gate of this robot is alive; raises Rejected or Unavailable."""
        key = keys.gate_alive(self._run, self._robot)
        for _ in range(TRIES):
            if not await self._bus.liveliness_get(key, PATIENCE):
                return
            await asyncio.sleep(PAUSE)
        raise Rejected(f"a robot has one gate, and that of robot {self._robot} in run '{self._run}' is alive already")

    def serve(self, start: Control, stop: Control, status: Control) -> None:
        """Take permits and answer queries from now on."""
        run, robot = self._run, self._robot
        self._bus.hold(self._bus.declare_subscriber(keys.permit(run), self._permits.put))
        for key, control, most in (
            (keys.gate_start(run, robot), start, MOST_ANSWERS),
            (keys.gate_stop(run, robot), stop, MOST_WITH_STOPS),
            (keys.gate_status(run, robot), status, MOST_ANSWERS),
        ):
            self._bus.declare_queryable(key, self._answering(control), partial(self._answers.has_room, most))
        self._bus.declare_token(keys.gate_alive(run, robot))  # last: it promises that all the others are declared

    def permits(self) -> list[tuple[int, Permit]]:
        """The Permits that have arrived since the last call, each with its time [ns]."""
        permits = []
        for received_at, _, payload in self._permits.take():
            try:
                permits.append((received_at, decode_permit(payload)))
            except MessageError as error:
                if not self._has_complained:
                    self._logger.warning("a permit is refused: %s", error)
                self._has_complained = True
        return permits

    def _answering(self, control: Control) -> Callable[[Query], None]:
        def answer(query: Query) -> None:
            try:
                send = partial(query.reply, encode_gate_status(control(query.payload)), SCHEMA)
            except FesError as error:
                send = partial(query.reply_err, str(error))
            self._answers.put(send)

        return answer
