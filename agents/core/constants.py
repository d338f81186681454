"""The constants of a crew for the compiled core, where the core has its laws."""

import ctypes
import math
from typing import Any, NamedTuple

import numpy as np

from agents.control.state import Crew
from agents.core.structures import NODES, Constants, Step
from agents.laws import collocation, link_estimates, neighbor_rules, packet_counting
from agents.laws.formation import PaperFormation
from agents.laws.seeking_measured import LinkSeeking, PooledSeeking
from agents.laws.seeking_perturbation import PerturbationSeeking, SampledSeeking
from fes.arrays.types import Ints
from fes.extension.context import LawContext
from fes.model.objective import share_of_reach

RULES: dict[type, int] = {
    neighbor_rules.Disk: 0,
    neighbor_rules.TwoNearest: 1,
    neighbor_rules.RelativeNeighborhood: 2,
    neighbor_rules.TolerantRelativeNeighborhood: 2,
}
ORACLE, SAMPLED, POOLED, ALONE = range(4)
"""Laws of the core, by their numbers in crew.h."""


class CrewConstants(NamedTuple):
    """The constants of a crew, and everything that they point to."""

    constants: Constants
    owned: list[Any]


def of(crew: Crew) -> CrewConstants | None:
    """The constants of a crew; None where the core lacks one of its laws or of its faults."""
    rule = RULES.get(type(crew.rule))
    if rule is None or type(crew.formation) is not PaperFormation or crew.transmitters.late:
        return None
    seeking: Any = crew.seeking
    result, owned = Constants(rule=rule), list[Any]()
    if isinstance(seeking, PerturbationSeeking):
        known = _perturbation(result, seeking, owned)
        context = seeking.context
    elif type(seeking) in (PooledSeeking, LinkSeeking):
        known, context = True, seeking.context
        _measured(result, seeking)
    else:
        return None
    if not known or not _streams(result, context, owned):
        return None
    _common(result, crew, context, owned)
    if result.safe_separation >= 0.0 and not crew.localizer.believes_fixes:
        return None  # the safe separation grows with the deviation of a pose
    return CrewConstants(result, owned)


def _perturbation(result: Constants, seeking: PerturbationSeeking, owned: list[Any]) -> bool:
    """The constants of (18); False where the core lacks its index."""
    config, seeker = seeking.seeker.config, seeking.seeker
    if type(seeking) is SampledSeeking:
        result.seeking = SAMPLED
    else:
        compiled = getattr(seeking, "compiled_index", lambda: None)()
        if compiled is None:
            return False
        result.index, settings = compiled
        owned.append(settings)
        result.index_settings, result.seeking = ctypes.addressof(settings), ORACLE
    result.extrapolates = config.law != "paper"
    result.sub_steps, result.index_gain = seeker.sub_steps, config.index_gain
    result.coupled, result.alone = _step(seeker.coupled), _step(seeker.alone)
    return True


def _step(step: collocation.Step) -> Step:
    flat = (step.nodes, step.washout_start, step.washout_input, step.path_start, step.path_input)
    numbers = np.concatenate([part.ravel() for part in flat])
    assert collocation.NODES == NODES
    return Step.from_buffer_copy(numbers.tobytes())


def _measured(result: Constants, seeking: PooledSeeking | LinkSeeking) -> None:
    """The constants of a learner."""
    is_pooled = type(seeking) is PooledSeeking
    method = packet_counting.POOLED if is_pooled else packet_counting.ALONE
    learner = result.method
    result.seeking, result.statistics = (POOLED if is_pooled else ALONE), seeking.statistics
    learner.short_share, learner.long_share = packet_counting.shares(method, seeking.context.dt)
    learner.slope_prior[:], learner.slopes[:], learner.gain = method.slope_prior, method.slopes, method.gain
    learner.scale = seeking.config.reference_separation


def _streams(result: Constants, context: LawContext, owned: list[Any]) -> bool:
    """The keys of the random numbers; False if they are not those of seeds."""
    streams = getattr(context.draws, "streams", None)
    if streams is None:
        return False
    for field, name in (("estimate_keys", link_estimates.FIRST_ESTIMATE), ("stagger_keys", link_estimates.STAGGER)):
        keys, first = streams(name, context.ids)
        setattr(result, field, _address(keys, owned))
        result.first = _address(first, owned)
    return True


def _common(result: Constants, crew: Crew, context: LawContext, owned: list[Any]) -> None:
    config, formation = crew.config, crew.config.formation
    seeking: Any = config.seeking
    result.robots, result.ids = len(crew.ids), _address(crew.ids, owned)
    result.dt, result.timeout = config.dt, crew.contact_timeout
    if type(crew.rule) is neighbor_rules.TolerantRelativeNeighborhood:
        result.tolerance = formation.link_tolerance
    result.low_estimate, result.high_estimate = seeking.initial_estimate
    result.dither_amplitude, result.dither_frequency = seeking.dither_amplitude, seeking.dither_frequency
    result.consensus_gain = seeking.consensus_gain
    preference = context.objective
    for name in ("minimum_separation", "maximum_separation", "shape_exponent"):
        setattr(result.objective, name, getattr(preference, name))
    result.objective.share_of_reach = share_of_reach(preference)
    for name in ("linear_gain", "angular_gain", "separation_gain", "give_way_gain"):
        setattr(result, name, getattr(formation, name))
    result.linear_limit = math.inf if formation.linear_limit is None else formation.linear_limit
    result.angular_limit = math.inf if formation.angular_limit is None else formation.angular_limit
    is_safe = formation.safe_separation is not None and formation.linear_limit is not None
    result.safe_separation = formation.safe_separation if is_safe else -1.0


def _address(values: Ints, owned: list[Any]) -> int:
    """The address of an array that lives as long as the constants."""
    values = np.ascontiguousarray(values)
    owned.append(values)
    return values.ctypes.data
