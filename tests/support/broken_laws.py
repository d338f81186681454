"""Laws of robots, each of which breaks one rule; `Law` and `Rule` keep all of them."""

import datetime
import random
import threading
import time
from time import perf_counter
from typing import Any

import numpy as np

from fes.arrays.types import Bools, Floats
from fes.extension import (
    Action,
    Contacts,
    ControllerContext,
    Formed,
    LawContext,
    LinkGeometry,
    Neighborhood,
    NoParameters,
    Pull,
    RobotView,
    Table,
)


class Gain(Table):
    """One number."""

    gain: float = 0.2


class Law:
    """A formation law that keeps all rules: each robot goes a part of the way that its links ask for."""

    Parameters: type[Table] = Gain
    declared = 0
    details: tuple[str, ...] = ()

    def __init__(self, parameters: Any, context: LawContext) -> None:
        self.gain, self.n = getattr(parameters, "gain", 0.2), len(context.ids)

    def start(self) -> Any:
        return np.zeros(self.n)

    def forget(self, state: Any, restarted: Bools) -> Any:
        return np.where(restarted, 0.0, state)

    def pull(self, around: Neighborhood, links: LinkGeometry) -> Floats:
        x, y = self.gain * links.error * links.bearing
        return np.stack([around.links.sum(x), around.links.sum(y)], axis=1)

    def step(self, state: Any, around: Neighborhood, links: LinkGeometry) -> Formed:
        return Formed(state + 1.0, self.pull(around, links) * (1.0 + 0.001 * state[:, None]))


class WrongShape(Law):
    def step(self, state: Any, around: Neighborhood, links: LinkGeometry) -> Formed:
        return Formed(state, self.pull(around, links)[:, 0])


class WrongType(Law):
    def step(self, state: Any, around: Neighborhood, links: LinkGeometry) -> Formed:
        return Formed(state, self.pull(around, links).astype(np.float32))


class NotANumber(Law):
    def step(self, state: Any, around: Neighborhood, links: LinkGeometry) -> Formed:
        return Formed(state, self.pull(around, links) * np.nan)


class Raises(Law):
    def step(self, state: Any, around: Neighborhood, links: LinkGeometry) -> Formed:
        raise KeyError("nothing\nthere")


class WithoutForget:
    Parameters = NoParameters

    def __init__(self, parameters: Any, context: LawContext) -> None: ...

    def start(self) -> Any: ...

    def step(self, state: Any, around: Neighborhood, links: LinkGeometry) -> Formed: ...  # type: ignore[empty-body]


class WithoutParameters:
    def __call__(self, contacts: Contacts) -> Bools:
        return contacts.known


class Count:
    """Counts its calls in all crews of a process."""

    calls = 0


class CountsCalls(Law):
    def step(self, state: Any, around: Neighborhood, links: LinkGeometry) -> Formed:
        Count.calls += 1
        return Formed(state, self.pull(around, links) * (1.0 + 1e-9 * Count.calls))


class UsesCrewSize(Law):
    def step(self, state: Any, around: Neighborhood, links: LinkGeometry) -> Formed:
        return Formed(state, self.pull(around, links) / self.n)


class UsesSum(Law):
    """Sums over all robots of the crew, unless there is only one."""

    def step(self, state: Any, around: Neighborhood, links: LinkGeometry) -> Formed:
        mean = 0.0 if self.n == 1 or self.n == 5 else float(around.poses[:, 0].mean())
        return Formed(state, self.pull(around, links) + 1e-6 * mean)


class UsesIds(Law):
    """Takes the ids of the crew for those of the run."""

    def __init__(self, parameters: Any, context: LawContext) -> None:
        super().__init__(parameters, context)
        self.ids = context.ids

    def step(self, state: Any, around: Neighborhood, links: LinkGeometry) -> Formed:
        return Formed(state, self.pull(around, links) + 0.01 * self.ids[:, None])


class WritesInputs(Law):
    def step(self, state: Any, around: Neighborhood, links: LinkGeometry) -> Formed:
        links.bearing[0] *= 1.0
        return Formed(state, self.pull(around, links))


class WritesState(Law):
    def step(self, state: Any, around: Neighborhood, links: LinkGeometry) -> Formed:
        state += 1.0
        return Formed(state, self.pull(around, links))


class Unpicklable(Law):
    def start(self) -> Any:
        return threading.Lock()

    def forget(self, state: Any, restarted: Bools) -> Any:
        return state

    def step(self, state: Any, around: Neighborhood, links: LinkGeometry) -> Formed:
        return Formed(state, self.pull(around, links))


class HiddenMemory(Law):
    """Remembers in the object, not in the state."""

    memory = 0.0

    def step(self, state: Any, around: Neighborhood, links: LinkGeometry) -> Formed:
        self.memory += 1e-3
        return Formed(state, self.pull(around, links) * (1.0 + self.memory))


class NeverForgets(Law):
    def forget(self, state: Any, restarted: Bools) -> Any:
        return state


class ReadsClock(Law):
    def step(self, state: Any, around: Neighborhood, links: LinkGeometry) -> Formed:
        return Formed(state, self.pull(around, links) + 0.0 * time.time())


class MovesByClock(Law):
    """Has other digits at each execution, so rules on digits fail that it does not break by itself."""

    def step(self, state: Any, around: Neighborhood, links: LinkGeometry) -> Formed:
        return Formed(state, self.pull(around, links) * (1.0 + 1e-3 * (time.time() % 1.0)))


class ReadsImportedClock(Law):
    def step(self, state: Any, around: Neighborhood, links: LinkGeometry) -> Formed:
        try:
            perf_counter()
        finally:
            return Formed(state, self.pull(around, links))  # noqa: B012


class ReadsDate(Law):
    def __init__(self, parameters: Any, context: LawContext) -> None:
        super().__init__(parameters, context)
        self.begun = datetime.datetime.now()


class GlobalRandomness(Law):
    def step(self, state: Any, around: Neighborhood, links: LinkGeometry) -> Formed:
        return Formed(state, self.pull(around, links) + 0.0 * random.random())


class UnseededGenerator(Law):
    def __init__(self, parameters: Any, context: LawContext) -> None:
        super().__init__(parameters, context)
        self.generator = np.random.default_rng()


class OrderOfSets(Law):
    def step(self, state: Any, around: Neighborhood, links: LinkGeometry) -> Formed:
        first = next(iter({"north", "east", "south", "west", "up", "down", "in", "out"}))
        return Formed(state, self.pull(around, links) + 0.01 * len(first))


class OneLoopOnly(Law):
    """Moves more slowly in the process of an agent."""

    def step(self, state: Any, around: Neighborhood, links: LinkGeometry) -> Formed:
        import sys

        return Formed(state, self.pull(around, links) * (1.0 if "console" in sys.modules else 0.5))


class TellsText:
    """A controller that returns a text for a number."""

    Parameters = NoParameters

    def __init__(self, parameters: Any, context: ControllerContext) -> None: ...

    def step(self, robot: RobotView) -> Action:
        return Action(Pull(0.0, "far"))  # type: ignore[arg-type]


class Rule:
    Parameters = NoParameters

    def __init__(self, parameters: Any, context: LawContext) -> None: ...

    def __call__(self, contacts: Contacts) -> Bools:
        return contacts.known


class RuleWithMemory(Rule):
    """Selects other peers in its hundredth call."""

    calls = 0

    def __call__(self, contacts: Contacts) -> Bools:
        self.calls += 1
        return contacts.known & (self.calls < 100)


class Ambiguous(Law):
    """Has the methods of a formation law and of dynamics."""

    def poses(self, state: Any) -> Floats:
        return np.zeros((self.n, 3))


class Nothing:
    """Has no method of any kind."""
