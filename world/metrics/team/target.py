"""The target of the team index: F of the shape that the team takes up, at the best length of its links."""

import math

import numpy as np

from fes.arrays import geometry
from fes.arrays.types import Floats
from fes.extension.context import WorldContext
from fes.model.config import FormationConfig
from fes.shapes import choice
from fes.shapes.shape import Shape
from world.config.radio import RadioConfig
from world.config.scenario import Scenario
from world.metrics.best_separation import best_separation
from world.metrics.team import delivery
from world.metrics.team.team_index import MAX_ROBOTS, TeamIndex, team_index
from world.simulation import reception

LATTICE = "lattice"
"""Shape of the target where no configuration is sought."""


def shape_of(n: int, formation: FormationConfig, losses: int) -> Shape | None:
    """The shape that `n` robots take up, the patch of the lattice without one; None if it has too few places."""
    name = LATTICE if formation.configuration == "none" else formation.configuration
    offsets = tuple((x, y) for x, y in formation.offsets)
    if n < 1 or (name == "offsets" and len(offsets) < n):
        return None
    return choice.shape(name, n, losses, offsets)


def spacing(shape: Shape, channel: RadioConfig, context: WorldContext) -> float:
    """r_beta [m]: the link length at which a shape has its best team index; NaN for a channel without an optimum."""
    config = context.objective
    return best_separation(context, channel, shape.quality_weight(config.losses, config.coverage_weight))


def sought_separation(scenario: Scenario, channel: RadioConfig, n: int) -> float:
    """The separation [m] that `n` robots seek: r_beta of their configuration, or r* where none is sought.

    NaN for a channel without an optimum.
    """
    context = reception.context(scenario)
    if scenario.formation.configuration == "none":
        return best_separation(context, channel)
    shape = shape_of(n, scenario.formation, context.objective.losses)
    return best_separation(context, channel) if shape is None else spacing(shape, channel, context)


def remarks(scenario: Scenario) -> list[str]:
    """A remark, in one line, if plans count on no link as long as the robots seek."""
    formation = scenario.formation
    if formation.configuration == "none":
        return []
    sought = sought_separation(scenario, scenario.channel, scenario.robots.number)
    if not sought > formation.keep_range:
        return []
    return [
        f"formation.keep_range, {formation.keep_range:g} m, is below the best link length of the configuration, "
        f"{sought:.3g} m: its links get no longer"
    ]


def target(n: int, formation: FormationConfig, channel: RadioConfig, context: WorldContext) -> float:
    """The team index of `n` robots in their shape at r_beta, over the channel without shadowing, bursts and jammers.

    NaN for a channel without an optimum, for fewer than two robots, and for more than MAX_ROBOTS.
    """
    if not 2 <= n <= MAX_ROBOTS:
        return math.nan
    shape = shape_of(n, formation, context.objective.losses)
    separation = math.nan if shape is None else spacing(shape, channel, context)
    if shape is None or not math.isfinite(separation):
        return math.nan
    index = of_positions(separation * shape.slots, channel, context)
    return math.nan if index is None else index.value


def of_positions(positions: Floats, channel: RadioConfig, context: WorldContext) -> TeamIndex | None:
    """The team index of robots at `positions` [n, 2] [m], over a channel that depends on separation alone.

    None for fewer than two robots, and for more than MAX_ROBOTS.
    """
    separation = geometry.distances(positions)
    probability = reception.model(channel, context).probability(separation)
    in_range = np.where(separation <= channel.communication_range, probability, 0.0)
    links = delivery.link_quality(separation, in_range, context.objective)
    return team_index(positions, links, context.objective)
