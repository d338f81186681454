"""Events of a run, for figures: changes of the channel, robots that leave and return, faults of their hardware."""

from collections.abc import Iterable
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from fes.arrays.types import Bools, Ints
from fes.model import counts
from world.config.faults import TransmitterConfig
from world.config.radio import RadioConfig
from world.config.scenario import Scenario

MOST_NAMED = 3
"""Most robots that an event names; it counts more."""


class Event(NamedTuple):
    """A change during a run."""

    tick: int
    text: str
    """The change in a few words, such as `robot 4 leaves`."""


def events(scenario: Scenario, channels: list[RadioConfig], present: list[Bools]) -> list[Event]:
    """The events of a run, from its channel [t] and its robots present [t][n] at each tick, in order.

    Faults of transmitters and clocks, and deaths of the world, are those that the scenario schedules.
    """
    happened = [*_of_channel(channels), *_of_robots(present), *_scheduled(scenario, len(present))]
    return sorted(happened, key=lambda event: event.tick)


def _of_channel(channels: list[RadioConfig]) -> Iterable[Event]:
    for tick, (before, after) in enumerate(pairwise(channels), 1):
        if after is not before and after != before:
            fields = [name for name in RadioConfig.model_fields if getattr(before, name) != getattr(after, name)]
            yield Event(tick, f"channel: {', '.join(fields)}")


def _of_robots(present: list[Bools]) -> Iterable[Event]:
    for tick, (before, after) in enumerate(pairwise(present), 1):
        if after is not before:
            for robots, verb in ((before & ~after, "leave"), (after & ~before, "join")):
                if robots.any():
                    yield Event(tick, _text(np.flatnonzero(robots), verb))


def _scheduled(scenario: Scenario, ticks: int) -> Iterable[Event]:
    for event in scenario.event:
        tick = counts.ticks(event.at, scenario.run.dt)
        if tick < ticks:
            for part in event.parts:
                kind = "transmitter" if isinstance(part, TransmitterConfig) else "clock"
                yield Event(tick, f"{kind} of robot {part.robot}")
            if event.world_away is not None:
                yield Event(tick, "world dies")


def _text(robots: Ints, verb: str) -> str:
    """The robots that leave or join, in words.

    >>> _text(np.array([4]), "leave"), _text(np.array([2, 5]), "join"), _text(np.arange(7), "leave")
    ('robot 4 leaves', 'robots 2, 5 join', '7 robots leave')
    """
    if len(robots) == 1:
        return f"robot {robots[0]} {verb}s"
    if len(robots) > MOST_NAMED:
        return f"{len(robots)} robots {verb}"
    return f"robots {', '.join(map(str, robots))} {verb}"
