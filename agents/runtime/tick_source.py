"""The ticks at which an agent steps: every tick in lockstep, the newest with a live clock."""

import time
from collections.abc import Callable, Iterator

from agents.control.ticks import Behind, End, LiveTicks, LockstepTicks, Reject, Resend
from agents.runtime.outbox import Outbox
from agents.runtime.world_liveliness import WorldLiveliness
from fes.errors import MessageError, Unavailable
from fes.protocol import keys, messages
from fes.protocol.messages import Observation
from fes.transport.drop_log import DropLog
from fes.transport.inbox import Item, ThreadInbox

Answer = Callable[[int, list[bytes]], bool]
"""Answers a tick from the payloads of the robots' observations, in id order; False if it has done nothing."""

SILENCE_TIMEOUT = 3600.0
"""An agent that receives nothing from a living world for this long [s] exits."""

QUIET = 5.0
"""After each silence of this length [s] an agent confirms its membership."""


def _answer_nothing(tick: int, observations: list[bytes]) -> bool:
    """Leave every tick."""
    return False


class TickSource:
    """Iterators over the ticks to answer. Each tick is a list of observations, one per robot in id order.

    An iterator blocks its thread until the next tick has arrived.
    """

    def __init__(
        self,
        run: str,
        robots: tuple[int, ...],
        inbox: ThreadInbox,
        outbox: Outbox,
        drops: DropLog,
        on_quiet: Callable[[], None] = lambda: None,
    ) -> None:
        """`on_quiet` is called after each silence of QUIET [s]."""
        self._robots, self._on_quiet = robots, on_quiet
        self._keys = [keys.observation(run, robot) for robot in robots]
        self._inbox, self._outbox = inbox, outbox
        self._drops = drops
        self._ticks: LockstepTicks[Observation] | LiveTicks[Observation] = LockstepTicks(robots)

    @property
    def tick(self) -> int:
        """The last tick answered; -1 before the first."""
        return self._ticks.tick

    @property
    def skipped(self) -> int:
        """Number of ticks that the live clock skipped, because a newer one had arrived."""
        return self._ticks.skipped

    def lockstep(self, world: WorldLiveliness, answer: Answer = _answer_nothing) -> Iterator[list[Observation]]:
        """Yield every tick, until the run is over; answer a repeated tick from the outbox. Raises Unavailable.

        It yields only the ticks that `answer` leaves.
        """
        self._ticks = ticks = LockstepTicks[Observation](self._robots)
        while True:
            items = self._arrived(ticks.missing)
            payloads = self._one_each(items) if ticks.is_between else None
            if payloads is not None and answer(ticks.tick + 1, payloads):
                ticks.answered()
                world.is_new = False
                continue
            for key, observation in self._decoded(items):
                action = ticks.receive(observation, world.is_new, self._outbox.has(observation.tick))
                if isinstance(action, End):
                    return
                if action is not None:
                    self._perform(action, key)
                if step := ticks.step():  # several ticks, if the world has not waited for this agent
                    world.is_new = False
                    yield step.observations

    def live(self, world: WorldLiveliness) -> Iterator[list[Observation]]:
        """Yield the newest tick of which all observations have arrived, until the run is over. Raises Unavailable."""
        self._ticks = ticks = LiveTicks[Observation](self._robots)
        while True:
            for _, observation in self._decoded(self._arrived(ticks.missing)):
                if ticks.receive(observation, world.is_new):
                    return
                world.is_new = False
            if step := ticks.step():
                yield step.observations

    def _perform(self, action: Resend | Reject | Behind, key: str) -> None:
        """Do what the observation that came on `key` asks for. Raises Unavailable if the agent is behind."""
        match action:
            case Resend(tick, robot):
                self._outbox.resend(tick, robot)
            case Reject(tick):
                self._drops.reject("Observation: is not for this tick", f"{key}: tick {tick}")
            case Behind(reason):
                raise Unavailable(reason)

    def _arrived(self, count: int) -> list[Item]:
        """Wait for `count` messages; all that have arrived, in their order."""
        if not self._inbox.wait(count, QUIET):
            self._outlast_silence(count)
        return self._inbox.drain()

    def _one_each(self, items: list[Item]) -> list[bytes] | None:
        """The payloads in the order of the robots, if there is one on the key of each robot, and nothing else."""
        by_key = {key: payload for key, payload in items if payload is not None}
        if len(items) != len(by_key) or len(by_key) != len(self._keys):
            return None
        payloads = [by_key[key] for key in self._keys if key in by_key]
        return payloads if len(payloads) == len(by_key) else None

    def _decoded(self, items: list[Item]) -> list[tuple[str, Observation]]:
        """Key and content of all messages that can be decoded."""
        read = [(key, self._read(key, payload)) for key, payload in items]
        return [(key, observation) for key, observation in read if observation is not None]

    def _outlast_silence(self, count: int) -> None:
        """Wait on for `count` messages after QUIET; raises Unavailable after SILENCE_TIMEOUT."""
        end = time.monotonic() + SILENCE_TIMEOUT - QUIET
        self._on_quiet()
        while not self._inbox.wait(count, QUIET):
            if time.monotonic() >= end:
                raise Unavailable(f"the world sent nothing for {SILENCE_TIMEOUT:g} s after tick {self.tick}")
            self._on_quiet()

    def _read(self, key: str, payload: bytes | None) -> Observation | None:
        try:
            if payload is None:
                raise MessageError("Observation", "a deletion is not an observation")
            observation = messages.decode_observation(payload)
            if keys.robot_of(key) != observation.robot:
                raise MessageError("Observation", "came on another robot's key", key)
        except MessageError as error:
            self._drops.unread(key, error)
            return None
        return observation
