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
    "formation law", "fes.formation_laws", {"paper": "agents.laws.formation:PaperFormation"}, CheckedFormation
)
SEEKING = Kind(
    "seeking law",
    "fes.seeking_laws",
    {
        "oracle": "agents.laws.oracle:OracleSeeking",
        "sampled": "agents.laws.seeking_perturbation:SampledSeeking",
        "measured, network": "agents.laws.seeking_measured:PooledSeeking",
        "measured, none": "agents.laws.seeking_measured:LinkSeeking",
    },
    CheckedSeeking,
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
METRIC = Kind("metric", "fes.metrics", {}, lambda extension, what, context: CheckedMetric(extension, what))

KINDS = (CONTROLLER, FORMATION, SEEKING, RULE, CHANNEL, DYNAMICS, METRIC)
