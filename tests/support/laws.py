"""Laws and neighbor rules by name, as a crew creates them."""

from typing import Any

from agents.laws.link_estimates import NO_SKEW
from fes.arrays.types import Ints
from fes.extension import registry
from fes.extension.context import LawContext, SeededDraws, WorldContext
from fes.extension.kinds import RULE
from fes.extension.protocols import NeighborRule
from fes.extension.told_channel import ToldChannel
from fes.model.config import ChannelConfig, ObjectiveConfig

RULES = sorted(RULE.built_in)
"""Names of the neighbor rules of fes."""


def context(ids: Ints, channel: ChannelConfig | None = None, dt: float = 0.02, seed: int = 0) -> LawContext:
    """The circumstances of a law of robots `ids` [n], whose clocks are exact."""
    told = None if channel is None else ToldChannel(channel)
    return LawContext(ids, dt, ObjectiveConfig(), SeededDraws(seed), lambda tick, links: NO_SKEW, told)


def rule(name: str, ids: Ints) -> NeighborRule:
    """The neighbor rule `name` of robots `ids` [n]."""
    created: Any = registry.create(RULE, name, context(ids))
    return created  # type: ignore[no-any-return]


def world(dt: float = 0.02, robots: int = 10, seed: int = 0) -> WorldContext:
    """The circumstances of a channel or a body of a world."""
    return WorldContext(dt, robots, ObjectiveConfig(), SeededDraws(seed))
