"""The seven kinds of extension: the group of their entry points, and those that come with fes, by dotted path."""

from collections.abc import Callable
from typing import Any, NamedTuple

from fes.extension.checked import (
    CheckedDynamics,
    CheckedFormation,
    CheckedMetric,
    CheckedRule,
    CheckedSeeking,
    checked_channel,
)


class Kind(NamedTuple):
    """A kind of extension."""

    name: str
    """In words, such as `neighbor rule`."""
    group: str
    """Group of entry points."""
    built_in: dict[str, str]
    """Name -> `module:Class` of those that come with fes."""
    checked: Callable[[Any, str, Any], Any] = lambda extension, what, context: extension
    """Wrapper that checks what an extension of others returns."""
    model_based: frozenset[str] = frozenset()
    """Built-in ones that must be told the channel: known without loading them."""


RULE = Kind(
    "neighbor rule",
    "fes.neighbor_rules",
    {
        "disk": "agents.laws.neighbor_rules:Disk",
        "two_nearest": "agents.laws.neighbor_rules:TwoNearest",
        "relative_neighborhood": "agents.laws.neighbor_rules:RelativeNeighborhood",
    },
    lambda extension, what, context: CheckedRule(extension, what),
)
FORMATION = Kind(
    "formation law",
    "fes.formation_laws",
    {
        "paper": "agents.laws.formation:PaperFormation",
        "alpha_lattice": "agents.rivals.alpha_lattice:AlphaLattice",
        "connectivity": "agents.rivals.connectivity:Connectivity",
        "gradient": "agents.rivals.gradient:Gradient",
        "voronoi": "agents.rivals.voronoi:Voronoi",
    },
    CheckedFormation,
    frozenset({"gradient"}),
)
SEEKING = Kind(
    "seeking law",
    "fes.seeking_laws",
    {
        "oracle": "agents.laws.oracle:OracleSeeking",
        "sampled": "agents.laws.seeking_perturbation:SampledSeeking",
        "measured, network": "agents.laws.seeking_measured:PooledSeeking",
        "measured, none": "agents.laws.seeking_measured:LinkSeeking",
        "fixed_separation": "agents.rivals.fixed_separation:FixedSeparation",
        "krstic_wang": "agents.rivals.krstic_wang:KrsticWang",
    },
    CheckedSeeking,
    frozenset({"oracle"}),
)
CONTROLLER = Kind("controller", "fes.controllers", {})
CHANNEL = Kind(
    "channel",
    "fes.channels",
    {
        "rayleigh": "world.simulation.formula:Formula",
        "logistic": "world.simulation.formula:Formula",
        "perfect": "world.simulation.formula:Formula",
        "table": "world.simulation.table:TableChannel",
        "trace": "world.simulation.trace:TraceChannel",
    },
    checked_channel,
)
DYNAMICS = Kind(
    "dynamics",
    "fes.dynamics",
    {"unicycle": "world.simulation.unicycle:Unicycle"},
    lambda extension, what, context: CheckedDynamics(extension, what),
)
METRIC = Kind(
    "metric",
    "fes.metrics",
    {
        "covered_area": "world.metrics.team.at_the_end:CoveredArea",
        "delivery": "world.metrics.team.at_the_end:TeamDelivery",
        "link_index": "world.metrics.team.link_index:LinkIndex",
        "links_connected": "world.metrics.team.links_connected:LinksConnected",
        "travel": "world.metrics.team.travel:Travel",
    },
    lambda extension, what, context: CheckedMetric(extension, what),
)

KINDS = (CONTROLLER, FORMATION, SEEKING, RULE, CHANNEL, DYNAMICS, METRIC)
