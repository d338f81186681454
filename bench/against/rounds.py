"""Both sides of a ratio in turn, so that a machine that slows down slows both."""

from collections.abc import Callable, Hashable, Mapping
from typing import TypeVar

Side = TypeVar("Side", bound=Hashable)
Number = TypeVar("Number")


def alternate(sides: Mapping[Side, Callable[[], Number]], rounds: int) -> dict[Side, list[Number]]:
    """The measurements of each side, one per round; every other round runs in the reverse order."""
    measured: dict[Side, list[Number]] = {side: [] for side in sides}
    for index in range(rounds):
        for side in sorted(sides, key=list(sides).index, reverse=index % 2 == 1):
            measured[side].append(sides[side]())
    return measured


def ratios(ours: list[float], theirs: list[float]) -> list[float]:
    """The ratio of each round."""
    return [one / other for one, other in zip(ours, theirs, strict=True)]
