"""The ticks that an agent answers: every tick in lockstep, the newest with a live clock. Pure.

A machine receives one observation at a time, and returns what its shell must do. The shell asks for the step when it
has read all messages that have arrived. The shell handles time, silence, and messages that cannot be decoded.
"""

from collections.abc import Iterable
from typing import Generic, NamedTuple, Protocol, TypeVar


class Stamped(Protocol):
    """The fields of an observation that choose the tick; a machine reads no other ones."""

    @property
    def tick(self) -> int:
        """Tick of the observation."""

    @property
    def robot(self) -> int:
        """Robot that it is for."""

    @property
    def over(self) -> bool:
        """True if the run is over."""

    @property
    def since(self) -> int:
        """Tick from which the robot takes part."""


Item = TypeVar("Item", bound=Stamped)


class Step(NamedTuple, Generic[Item]):
    """Answer a tick."""

    observations: list[Item]
    """One per robot, in id order."""


class Resend(NamedTuple):
    """Publish a robot's payloads of a stored tick again: the world repeats this tick."""

    tick: int
    robot: int


class Reject(NamedTuple):
    """Count an observation that is not for this tick."""

    tick: int


class Behind(NamedTuple):
    """End the agent: a restarted world needs a tick that is no longer stored."""

    reason: str


class End(NamedTuple):
    """End without an error: the run is over."""

    tick: int
    """The last tick answered; -1 before the first."""


Action = Resend | Reject | Behind | End


class LockstepTicks(Generic[Item]):
    """Each tick in its turn. A repeated tick is sent again from the outbox, and not stepped a second time."""

    skipped = 0
    """Number of ticks skipped; always 0 in lockstep."""

    def __init__(self, robots: Iterable[int]) -> None:
        """`robots` are those of the agent, ascending."""
        self._robots = tuple(robots)
        self._waiting: dict[int, Item] = {}
        self._forgotten = -1
        self._is_over = False
        self.tick = -1
        """The last tick answered. A robot that rejoins counts the ticks of its absence as answered."""

    @property
    def missing(self) -> int:
        """Number of observations without which the next tick cannot be answered."""
        return len(self._robots) - len(self._waiting)

    def receive(self, observation: Item, world_is_new: bool, is_stored: bool) -> Action | None:
        """Take one observation; None if the shell has nothing to do.

        `world_is_new`: the world has restarted, and no tick was answered since. `is_stored`: the outbox still has
        the payloads of the observation's tick.
        """
        tick = observation.tick
        if self._is_over or observation.over:
            self._is_over = True
            return End(self.tick)
        if tick > self.tick + 1 and observation.since == tick:  # the run continued without this agent
            self.tick = tick - 1
            self._waiting.clear()
        if tick == self.tick + 1:
            self._waiting.setdefault(observation.robot, observation)
            return None
        if tick == self.tick or (world_is_new and tick < self.tick):
            # A restarted world repeats its last tick, or the one before. The outbox still has both.
            return Resend(tick, observation.robot) if is_stored else self._forget(tick)
        # An agent that has joined may have to wait for its first tick.
        return Reject(tick) if self.tick >= 0 else None

    def step(self) -> Step[Item] | None:
        """The next tick, if all its observations have arrived. From then on the world is not new."""
        if self._is_over or self.missing:
            return None
        observations = [self._waiting[robot] for robot in self._robots]
        self._waiting.clear()
        self.tick += 1
        return Step(observations)

    @property
    def is_between(self) -> bool:
        """True if no observation of the next tick was received yet, and the run is not over."""
        return not self._waiting and not self._is_over

    def answered(self) -> None:
        """The next tick was answered by other means, while `is_between`. From then on the world is not new."""
        self.tick += 1

    def _forget(self, tick: int) -> Action | None:
        """Handle a request for a tick that is not stored: the second one for the same tick ends the agent."""
        if tick == self.tick:  # it passed while the robot was absent
            return None
        if tick == self._forgotten:
            return Behind(f"the world is back at tick {tick}, but tick {self.tick} was answered already")
        self._forgotten = tick
        return Reject(tick)


class LiveTicks(Generic[Item]):
    """The newest tick of which all observations have arrived. Older ones are skipped, late ones have no effect."""

    missing = 1
    """Number of observations to wait for: each one may complete a tick."""

    def __init__(self, robots: Iterable[int]) -> None:
        """`robots` are those of the agent, ascending."""
        self._robots = tuple(robots)
        self._newer: dict[int, dict[int, Item]] = {}
        self._is_over = False
        self.tick = -1
        """The last tick answered, or the one before that from which the world resumed."""
        self.skipped = 0
        """Number of ticks skipped, because a newer one had arrived."""

    def receive(self, observation: Item, world_is_new: bool) -> End | None:
        """Take one observation; None if the shell has nothing to do. From then on the world is not new."""
        if self._is_over or observation.over:
            self._is_over = True
            return End(self.tick)
        if world_is_new and observation.tick <= self.tick:  # the world resumed from an earlier tick
            self.tick = observation.tick - 1
        if observation.tick > self.tick:
            self._newer.setdefault(observation.tick, {})[observation.robot] = observation
        return None

    def step(self) -> Step[Item] | None:
        """The newest complete tick, if there is one."""
        complete = [tick for tick, by_robot in self._newer.items() if len(by_robot) == len(self._robots)]
        if self._is_over or not complete:
            return None
        tick, before = max(complete), self.tick
        observations = [self._newer[tick][robot] for robot in self._robots]
        self._newer = {later: by_robot for later, by_robot in self._newer.items() if later > tick}
        if before >= 0 and observations[0].since <= before:
            self.skipped += tick - before - 1
        self.tick = tick
        return Step(observations)
