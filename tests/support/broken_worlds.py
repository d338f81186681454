"""Channels, dynamics and metrics, each of which breaks one rule; `Channel`, `Bodies` and `Metric` keep all."""

import threading
from collections.abc import Mapping
from typing import Any

import numpy as np

from fes.arrays.types import Floats
from fes.extension import NoParameters, Table, WorldContext


class Gain(Table):
    """One number."""

    gain: float = 0.2


class Channel:
    Parameters = Gain

    def __init__(self, parameters: Gain, context: WorldContext) -> None: ...

    def probability(self, separation: Floats) -> Floats:
        return np.exp(-((separation / 120.0) ** 3))


class MoreThanCertain(Channel):
    def probability(self, separation: Floats) -> Floats:
        return 2.0 * super().probability(separation)


class WritesSeparation(Channel):
    def probability(self, separation: Floats) -> Floats:
        separation *= 1.0
        return super().probability(separation)


class Bodies:
    Parameters = NoParameters

    def __init__(self, parameters: Any, context: WorldContext) -> None: ...

    def start(self, poses: Floats) -> Any:
        return poses

    def step(self, state: Any, twists: Floats, dt: float) -> Any:
        moved: Floats = state + dt * np.stack([twists[:, 0], 0.0 * twists[:, 0], twists[:, 1]], axis=1)
        return moved

    def poses(self, state: Any) -> Floats:
        poses: Floats = state
        return poses


class BodiesWithGenerator(Bodies):
    """Their state holds a generator of random numbers, which no checkpoint holds."""

    def start(self, poses: Floats) -> Any:
        return poses, np.random.default_rng(3)

    def step(self, state: Any, twists: Floats, dt: float) -> Any:
        return super().step(state[0], twists, dt), state[1]

    def poses(self, state: Any) -> Floats:
        poses: Floats = state[0]
        return poses


class Metric:
    Parameters = NoParameters

    def __init__(self, parameters: Any, context: WorldContext) -> None:
        self.total = 0.0

    def add(self, tick: Any) -> None:
        self.total += float(tick.separation.sum())

    def result(self) -> Mapping[str, float | None]:
        return {"total": self.total}


class MetricWithNestedParameters(Metric):
    """Keeps all rules, with its parameters as the tutorial writes them."""

    class Parameters(Table):
        """One number."""

        gain: float = 0.2

    def __init__(self, parameters: Any, context: WorldContext) -> None:
        super().__init__(parameters, context)
        self.parameters = parameters


class InfiniteMetric(Metric):
    def result(self) -> Mapping[str, float | None]:
        return {"total": float("inf")}


class MetricWithLock(Metric):
    def __init__(self, parameters: Any, context: WorldContext) -> None:
        super().__init__(parameters, context)
        self.lock = threading.Lock()


class MetricOfSharedState(Metric):
    """Adds up in the class."""

    sums: list[float] = []  # noqa: RUF012

    def add(self, tick: Any) -> None:
        self.sums.append(float(tick.separation.sum()))

    def result(self) -> Mapping[str, float | None]:
        return {"total": sum(self.sums)}
