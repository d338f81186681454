"""Each kernel of the robots by itself repeats its numpy twin to the bit, over random crews."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from agents.control import links as linking
from agents.control import motion, separation
from agents.control.state import Crew, CrewState
from agents.core import compiled_crew
from agents.laws import packet_counting
from agents.laws.formation import formation_vector
from agents.laws.seeking_measured import Measured
from fes.arrays import geometry
from fes.arrays.types import Floats
from fes.extension.protocols import Formed
from fes.model.sensing import MAX_TWIST, OPENING_TICKS, bounded
from tests.support import bits, cores, random_teams
from tests.support.kernels import MEASURED_SEEK, PERTURBATION_SEEK, Kernels
from tests.support.random_teams import Round, Size

pytestmark = cores.needs(compiled_crew.load())

SAFE: dict[str, Any] = {
    "formation__linear_limit": 5.0,
    "formation__angular_limit": 3.0,
    "formation__safe_separation": 20.0,
    "formation__separation_gain": 0.25,
    "robots__poses": [[0.0, 0.0, 0.0], [60.0, 0.0, 0.0]],
}
CREWS: dict[str, tuple[str, dict[str, Any]]] = {
    "oracle": ("paper", SAFE),
    "oracle, as printed": ("paper-as-printed", {"formation__rule": "disk"}),
    "oracle, logarithm": ("paper", {"seeking__index_transform": "log", "run__clock_skew": 0.05}),
    "oracle, sub-steps": ("paper", {"seeking__sub_step": 0.005, "formation__rule": "relative_neighborhood"}),
    "oracle, sub-steps and skew": ("paper", {"seeking__sub_step": 0.01, "run__clock_skew": 0.05}),
    "oracle, logistic": ("paper", {"channel__model": "logistic", "seeking__index_transform": "log"}),
    "oracle, logistic, J": ("paper", {"channel__model": "logistic", "formation__rule": "disk"}),
    "oracle, perfect": ("paper", {"channel__model": "perfect"}),
    "oracle, exponents": (
        "paper",
        {"channel__path_loss_exponent": 2.7, "objective__shape_exponent": 3.3, "seeking__index_transform": "log"},
    ),
    "sampled": ("paper", {"seeking__index": "sampled", "formation__rule": "tolerant_relative_neighborhood", **SAFE}),
    "sampled, skew": ("paper", {"seeking__index": "sampled", "run__clock_skew": 0.05, "formation__rule": "disk"}),
    "pooled": ("measured", {"formation__rule": "tolerant_relative_neighborhood", **SAFE}),
    "pooled, two nearest": ("measured", {"formation__rule": "two_nearest", "objective__shape_exponent": 3.3}),
    "alone": ("measured", {"seeking__pooling": "none", "run__clock_skew": 0.05}),
    "alone, disk": ("measured", {"seeking__pooling": "none", "formation__rule": "disk", **SAFE}),
}
SIZES = {"crowd": Size(300, 12, 8), "one robot": Size(1, 2, 12), "few": Size(3, 4, 16), "dense": Size(40, 60, 3)}
CASES = [
    (crew, size, strange) for crew in CREWS for size, strange in [("crowd", 0.0), *((size, 0.1) for size in SIZES)]
]


@pytest.fixture(autouse=True)
def _quiet() -> Iterator[None]:
    with np.errstate(all="ignore"):
        yield


def each(name: str, size: str, strange: float) -> Iterator[tuple[Crew, Kernels, Round]]:
    """The rounds of a case."""
    scenario, overrides = CREWS[name]
    crew = random_teams.crew_of(scenario, SIZES[size].robots, **overrides)
    kernels = Kernels(crew)
    for one in random_teams.rounds(crew, SIZES[size], seed=len(name) + len(size), strange=strange):
        yield crew, kernels, one


@pytest.mark.parametrize(("name", "size", "strange"), CASES)
def test_every_kernel_repeats_numpy(name: str, size: str, strange: float) -> None:
    for crew, kernels, one in each(name, size, strange):
        for kernel in (contacts, rule, links, formation, twists, seeking):
            found = kernel(crew, kernels, one)
            assert not found, (kernel.__name__, one.observations.tick, found)


@pytest.mark.parametrize("law", ["consensus", "paper"])
@pytest.mark.parametrize("index", ["oracle", "sampled"])
def test_zeros_of_both_signs_give_zeros_with_the_signs_of_numpy(index: str, law: str) -> None:
    crew = random_teams.crew_of("paper", 100, seeking__index=index, seeking__law=law)
    kernels, generator = Kernels(crew), np.random.default_rng(7)
    for one in random_teams.rounds(crew, Size(100, 12, 5), seed=3):
        state = generator.choice([0.0, -0.0, -1.0, 70.0], (3, len(one.relinked.links.edges)))
        estimates = generator.choice([0.0, -0.0, np.nan], len(one.known.edges))
        known = one.known._replace(estimates=estimates)
        around, relinked = one.around._replace(contacts=known), one.relinked._replace(contacts=known)
        zeros = replace(one, known=known, relinked=relinked, around=around)
        ours = kernels.seek(zeros, PERTURBATION_SEEK, state)
        assert not bits.differences(ours, crew.seeking.seek(state, around))


def contacts(crew: Crew, kernels: Kernels, one: Round) -> list[str]:
    return bits.differences(kernels.contacts(one).contacts._replace(declared=one.known.declared), one.known)


def rule(crew: Crew, kernels: Kernels, one: Round) -> list[str]:
    return bits.differences(kernels.selected(one), one.selected)


def links(crew: Crew, kernels: Kernels, one: Round) -> list[str]:
    state, selected = kernels.linked(one)
    expected = one.relinked
    ours = state.links, state.linked_since, selected, of_links(state)
    return bits.differences(
        ours, (expected.links, expected.linked_since, one.selected[expected.links.contact], of_links(expected))
    )


def of_links(state: CrewState) -> Any:
    """The seeking state as far as new links change it: pooled counts are those of robots."""
    seeking = state.seeking
    is_pooled = isinstance(seeking, Measured) and seeking.fit.method is packet_counting.POOLED
    return seeking.estimates if is_pooled else seeking


def desired(crew: Crew, one: Round) -> Floats:
    return np.asarray(crew.seeking.desired(one.relinked.seeking, one.observations.tick, one.relinked.links.edges))


def formation(crew: Crew, kernels: Kernels, one: Round) -> list[str]:
    wanted = desired(crew, one)
    near = linking.geometry(one.known, one.relinked.links, wanted, None)
    pull = formation_vector(one.relinked.links.edges, near.error, near.bearing)
    return bits.differences(kernels.pull(one, wanted), pull)


def twists(crew: Crew, kernels: Kernels, one: Round) -> list[str]:
    """Safe separation and the twists, from a pull of any length."""
    config, dt, sensed = crew.config.formation, crew.config.dt, one.observations.sensed
    heading = sensed.poses[:, geometry.HEADING]
    generator = np.random.default_rng(one.observations.tick)
    pull = bits.sprinkled(generator, generator.normal(0.0, 10.0, (len(crew.ids), 2)), 0.1)
    found: list[str] = []
    peers = separation.near(one.known, sensed, dt, config)
    if peers is not None:
        slow = separation.give_way(Formed(None, pull), peers, config).pull
        found += bits.differences(kernels.give_way(one, pull), slow, "give_way")
        pull = slow
    free = motion.twist(pull, heading, dt, config)
    found += bits.differences(kernels.twists(one, pull), free, "twists")
    if peers is not None:
        free = bounded(np.where(np.isfinite(free), free, 0.0), MAX_TWIST)
        is_new = sensed.tick - one.since < OPENING_TICKS
        safe = separation.slow_down(free, peers, heading, is_new, dt, config)
        found += bits.differences(kernels.slow_down(one, free), safe, "slow_down")
    return found


def seeking(crew: Crew, kernels: Kernels, one: Round) -> list[str]:
    """The counting of beacons, and the step of the estimates."""
    law, state, found = crew.seeking, one.relinked.seeking, []
    kernel = PERTURBATION_SEEK
    if hasattr(state, "fit"):
        kernel, state = MEASURED_SEEK, law.measure(state, one.around, Formed(None, np.zeros(0)))
        ours = kernels.measured(one)
        found += bits.differences((ours.estimates, ours.ahead, ours.fit), (state.estimates, state.ahead, state.fit))
    ours, numpy = kernels.seek(one, kernel, state), law.seek(state, one.around)
    return found + bits.differences(ours, numpy)
