"""The seven kinds of extension: their groups of entry points, and the built-in ones by dotted path."""

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
    members: tuple[tuple[str, ...], ...] = ()
    """Alternative sets of members, of which a class of this kind has one; empty if it needs none."""
    checked: Callable[[Any, str, Any], Any] = lambda extension, what, context: extension
    """Wrapper that checks the values that an extension returns; built-in ones are not wrapped."""
    model_based: frozenset[str] = frozenset()
    """Names of the built-in ones that must be told the channel, so that no class is loaded to find out."""
    settled: frozenset[str] = frozenset()
    """Names of the built-in ones whose parameters are the scenario's table of this kind itself."""

    def missing(self, loaded: Any) -> str:
        """The first member that a class lacks; empty if it has all of them.

        >>> RULE.missing(object), RULE.missing(type("Rule", (), {"__call__": print}))
        ('__call__', '')
        """
        lacking = [[name for name in names if not _has(loaded, name)] for names in self.members]
        return min(lacking, key=len)[0] if lacking and all(lacking) else ""


def _has(loaded: Any, name: str) -> bool:
    """True if a class has a method; every class can be called, so `__call__` must stand in its own namespace."""
    if name == "__call__":
        return any(name in vars(base) for base in getattr(loaded, "__mro__", ()))
    return callable(getattr(loaded, name, None))


def infer(loaded: Any) -> list[Kind]:
    """The kinds of which a class has all members. Of two, where one has all members of the other, the larger one.

    A class that has a state, by `start`, is not a controller: a controller is its own state.
    """
    complete = [(kind, set(names)) for kind in KINDS for names in kind.members if all(_has(loaded, n) for n in names)]
    specific = [kind for kind, names in complete if not any(names < larger for _, larger in complete)]
    return [kind for kind in specific if kind is not CONTROLLER or not _has(loaded, "start")]


def nearest(loaded: Any) -> Kind | None:
    """The kind of which a class lacks the fewest of several members; None if it has none of any kind."""
    counts = [
        (len([name for name in names if not _has(loaded, name)]), kind)
        for kind in KINDS
        for names in kind.members
        if any(_has(loaded, name) for name in names)
    ]
    few = [(count, kind) for count, kind in counts if count]
    return min(few, key=lambda entry: entry[0])[1] if few else None


RULE = Kind(
    "neighbor rule",
    "fes.neighbor_rules",
    {
        "disk": "agents.laws.neighbor_rules:Disk",
        "two_nearest": "agents.laws.neighbor_rules:TwoNearest",
        "relative_neighborhood": "agents.laws.neighbor_rules:RelativeNeighborhood",
        "tolerant_relative_neighborhood": "agents.laws.neighbor_rules:TolerantRelativeNeighborhood",
    },
    (("__call__",),),
    lambda extension, what, context: CheckedRule(extension, what),
    settled=frozenset({"tolerant_relative_neighborhood"}),
)
FORMATION = Kind(
    "formation law",
    "fes.formation_laws",
    {
        "paper": "agents.laws.formation:PaperFormation",
        "goals": "agents.laws.goals:Goals",
        "alpha_lattice": "agents.rivals.alpha_lattice:AlphaLattice",
        "connectivity": "agents.rivals.connectivity:Connectivity",
        "gradient": "agents.rivals.gradient:Gradient",
        "marks_and_plans": "agents.configuration.law:MarksAndPlans",
        "voronoi": "agents.rivals.voronoi:Voronoi",
    },
    (("start", "forget", "step"),),
    CheckedFormation,
    frozenset({"gradient"}),
    frozenset({"marks_and_plans"}),
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
    (("start", "forget", "relink", "desired", "measure", "publish", "seek"),),
    CheckedSeeking,
    frozenset({"oracle"}),
)
CONTROLLER = Kind("controller", "fes.controllers", {}, (("step",),))
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
    (("probability",), ("pair_probability",)),
    checked_channel,
)
DYNAMICS = Kind(
    "dynamics",
    "fes.dynamics",
    {"unicycle": "world.simulation.unicycle:Unicycle"},
    (("start", "step", "poses"),),
    lambda extension, what, context: CheckedDynamics(extension, what, context.robots),
)
METRIC = Kind(
    "metric",
    "fes.metrics",
    {
        "covered_area": "world.metrics.team.at_the_end:CoveredArea",
        "delivery": "world.metrics.team.at_the_end:TeamDelivery",
        "link_index": "world.metrics.team.link_index:LinkIndex",
        "links_connected": "world.metrics.team.links_connected:LinksConnected",
        "team_index": "world.metrics.team.at_the_end:TeamIndexAtTheEnd",
        "travel": "world.metrics.team.travel:Travel",
    },
    (("add", "result"),),
    lambda extension, what, context: CheckedMetric(extension, what),
)

KINDS = (CONTROLLER, FORMATION, SEEKING, RULE, CHANNEL, DYNAMICS, METRIC)
