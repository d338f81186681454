"""A crew during a run has the same digits, the same state and the same errors with either core."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from agents.control import crew as crews
from agents.control.state import Crew
from agents.core import compiled_crew
from agents.runtime.crew_run import CrewRun
from fes.arrays.edges import Edges
from fes.errors import FesError
from fes.model.sensing import Observations, no_beacons
from tests.support import bits, cores, loop, random_teams
from tests.support.random_teams import Size
from world.config.scenario import agent_config
from world.simulation import truth

pytestmark = cores.needs(compiled_crew.load())

LAWS: dict[str, tuple[str, dict[str, Any]]] = {
    "oracle": ("paper", {}),
    "oracle with skew": ("paper", {"run__clock_skew": 0.05, "seeking__sub_step": 0.01}),
    "sampled": ("paper", {"seeking__index": "sampled"}),
    "pooled": ("measured", {}),
    "alone": ("measured", {"seeking__pooling": "none", "formation__rule": "disk"}),
    "safe": (
        "measured",
        {"formation__linear_limit": 5.0, "formation__safe_separation": 20.0, "formation__separation_gain": 0.2},
    ),
}

NOISY: dict[str, tuple[str, dict[str, Any]]] = {
    "noisy": ("measured", {"sensing__pose_noise": 1.0, "sensing__heading_noise": 0.1, "robots__slip": 0.05}),
    "slow": ("paper", {"sensing__pose_rate": 5.0, "sensing__pose_latency": 0.04}),
    "lagging": ("measured", {"sensing__pose_noise": 0.1, "sensing__pose_rate": 9.0, "robots__actuator_lag": 0.2}),
    "exact but lagging": ("measured", {"robots__actuator_lag": 0.2}),
    "unfiltered": ("paper", {"sensing__pose_noise": 1.0, "sensing__pose_rate": 9.0, "localization__filter": "none"}),
}


@pytest.fixture(autouse=True)
def _quiet() -> Iterator[None]:
    with np.errstate(all="ignore"):
        yield


def both(crew: Crew) -> tuple[CrewRun, CrewRun]:
    """The crew on the compiled core, and on numpy."""
    compiled = CrewRun(crew)
    with cores.only_numpy():
        numpy = CrewRun(crew)
    assert (compiled.compiled is not None, numpy.compiled is not None) == (True, False)
    return compiled, numpy


@pytest.mark.parametrize("name", [*LAWS, *NOISY])
def test_a_crew_sends_the_same_and_has_the_same_state_after_every_tick(name: str) -> None:
    file, settings = (LAWS | NOISY)[name]
    scenario = loop.load(f"{file}.toml", **settings)
    world = truth.create(scenario)
    state, beacons = truth.start(world), no_beacons()
    crew = crews.create(agent_config(scenario), world.ids)
    compiled, numpy = both(crew)
    theirs = beacons
    restarted = np.arange(10) % 3 == 0
    for tick in range(120):
        if tick in (40, 41, 90):  # in the middle of a run, and twice in a row
            compiled.forget(restarted)
            numpy.forget(restarted)
            assert not bits.differences(compiled.state, numpy.state)
        observations = truth.observe(state)
        sent, expected = compiled.step(observations, beacons), numpy.step(observations, theirs)
        beacons, theirs = sent.beacons, expected.beacons
        assert not bits.differences(sent, expected), tick
        assert not bits.differences(compiled.state, numpy.state), tick
        state = truth.step(world, state, sent.twists)
    assert compiled.compiled is not None


@pytest.mark.parametrize("name", LAWS)
def test_beacons_of_others_and_random_inputs_give_the_same_ticks(name: str) -> None:
    overrides = LAWS[name][1] | {"robots__poses": [[0.0, 0.0, 0.0], [60.0, 0.0, 0.0]]}
    crew = random_teams.crew_of(LAWS[name][0], 20, **overrides)
    compiled, numpy = both(crew)
    for one in random_teams.rounds(crew, Size(20, 8, 25), seed=len(name)):
        sent = compiled.step(one.observations, one.beacons)
        assert not bits.differences(sent, numpy.step(one.observations, one.beacons))
        assert not bits.differences(compiled.state, numpy.state)


@pytest.mark.parametrize("name", LAWS)
def test_a_state_that_goes_through_a_buffer_is_the_same_state(name: str) -> None:
    crew = random_teams.crew_of(LAWS[name][0], 30, **LAWS[name][1] | {"robots__poses": [[0.0, 0.0, 0.0]]})
    compiled = compiled_crew.of(crew)
    assert compiled is not None
    for one in random_teams.rounds(crew, Size(30, 8, 10), seed=2, strange=0.1):
        compiled.state = one.relinked
        state = compiled.state
        expected = one.relinked._replace(contacts=one.relinked.contacts._replace(declared=state.contacts.declared))
        assert not bits.differences(state, expected)


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("value", [np.nan, np.inf, 1e300])
def test_a_twist_that_is_not_finite_is_the_error_of_numpy_and_leaves_the_state_before(
    name: str, value: float
) -> None:
    crew = random_teams.crew_of(LAWS[name][0], 12, **LAWS[name][1] | {"robots__poses": [[0.0, 0.0, 0.0]]})
    compiled, numpy = both(crew)
    *begun, last = random_teams.rounds(crew, Size(12, 6, 8), seed=4)
    for one in begun:
        compiled.step(one.observations, one.beacons)
        numpy.step(one.observations, one.beacons)
    before, poses = compiled.state, last.observations.poses.copy()
    poses[7, 2] = value
    given = Observations(last.observations.tick, poses, last.observations.in_range, last.observations.reception)
    if value == 1e300:
        assert not bits.differences(compiled.step(given, last.beacons), numpy.step(given, last.beacons))
        return
    with pytest.raises(FesError, match="computed a twist that is not finite") as expected:
        numpy.step(given, last.beacons)
    with pytest.raises(FesError) as error:
        compiled.step(given, last.beacons)
    assert str(error.value) == str(expected.value)
    assert compiled.compiled is None
    assert not bits.differences(compiled.state, before)


def test_after_an_error_numpy_continues_with_the_same_digits() -> None:
    crew = random_teams.crew_of("paper", 12)
    compiled, numpy = both(crew)
    for index, one in enumerate(random_teams.rounds(crew, Size(12, 6, 12), seed=5)):
        if index == 6:
            poses = np.full_like(one.observations.poses, np.nan)
            given = Observations(one.observations.tick, poses, one.observations.in_range, one.observations.reception)
            with pytest.raises(FesError):
                compiled.step(given, one.beacons)
        assert not bits.differences(
            compiled.step(one.observations, one.beacons), numpy.step(one.observations, one.beacons)
        )
        assert not bits.differences(compiled.state, numpy.state)


def test_a_robot_alone_has_the_same_ticks() -> None:
    for name, overrides in LAWS.values():
        crew = random_teams.crew_of(name, 1, **overrides | {"robots__poses": [[0.0, 0.0, 0.0]]})
        compiled, numpy = both(crew)
        nobody = np.zeros(0, np.int64)
        for tick in range(5):
            near = Edges(crew.ids, nobody, nobody)
            given = Observations(tick, np.array([[1.0, 2.0, 3.0 + tick]]), near, np.zeros(0, np.uint8))
            beacons = no_beacons()
            assert not bits.differences(compiled.step(given, beacons), numpy.step(given, beacons))
            assert not bits.differences(compiled.state, numpy.state)


def test_fixes_that_become_old_and_new_again_give_the_same_digits_with_either_core() -> None:
    scenario = loop.load("measured.toml")
    world = truth.create(scenario)
    state, beacons = truth.start(world), no_beacons()
    compiled, numpy = both(crews.create(agent_config(scenario), world.ids))
    theirs, generator, fixed = beacons, np.random.default_rng(3), np.zeros(10, dtype=np.int64)
    for tick in range(160):
        is_late = tick // 20 % 2 == 1
        fixed = np.where(generator.random(10) < 0.5, tick, fixed) if is_late else np.full(10, tick)
        if tick in (37, 53, 70):
            for run in (compiled, numpy):
                run.forget(np.arange(10) % 3 == 0)
        observations = replace(truth.observe(state), fixed=fixed)
        ours, other = compiled.step(observations, beacons), numpy.step(observations, theirs)
        assert not bits.differences(ours, other), tick
        assert not bits.differences(compiled.state, numpy.state), tick
        has_payloads = compiled.payloads(ours, state.since, state.present, state.decodable) is not None
        assert has_payloads == (fixed == tick).all()
        beacons, theirs = ours.beacons, other.beacons
        state = truth.step(world, state, ours.twists)
    assert compiled.compiled is not None
