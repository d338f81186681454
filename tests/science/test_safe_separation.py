"""Robots keep their safe separation under every pull: the short form of `python -m tests.support.passing`."""

from math import isfinite, pi

import numpy as np
import pytest

from agents.control import separation
from agents.control.separation import Near
from fes.arrays.types import Floats
from fes.extension import registry
from tests.support import drivers, loop
from tests.support.passing import WITHOUT_GOALS
from tests.support.passing_kinds import batches
from tests.support.passing_runs import Batch, Outcome, Team, placed, run

SAFE = 5.0
SHORT = {
    "circle of 2": 2,
    "circle of 6": 2,
    "circle of 10": 1,
    "box of 100 m, 10": 2,
    "march through a crowd": 1,
    "one stands still": 2,
    "pursuit": 3,
    "squeeze": 2,
    "random pulls": 2,
    "bursts, timeout 5 s": 2,
    "bursts, timeout 1 s": 2,
    "clocks off": 2,
    "one dies": 2,
    "one sends old places": 2,
}
"""Kind -> number of runs. Lanes and controllers have tests of their own."""

BREAKING = {"one dies", "bursts, timeout 1 s", "one sends old places"}
"""Kinds of which each run breaks a condition."""


@pytest.fixture(scope="module")
def outcomes() -> dict[str, list[Outcome]]:
    """The runs of each kind."""
    results = [outcome for batch in batches(SHORT, seed=5, longest=12.0) for outcome in run(batch)]
    return {kind: [outcome for outcome in results if outcome.kind == kind] for kind in SHORT}


def lanes(speed: float, length: float, longest: float) -> Batch:
    """Two robots side by side, of which each wants to be on the side of the other one at the end of a long way."""
    starts = np.array([[0.0, 0.0, 0.5 * pi], [6.0, 0.0, 0.5 * pi]])
    team = Team("lanes", starts, np.array([[6.0, length], [0.0, length]]), {})
    return Batch([team], {"linear_limit": speed, "separation_gain": min(1.0, speed / SAFE)}, longest=longest)


@pytest.mark.slow
@pytest.mark.parametrize("kind", SHORT)
def test_no_two_robots_come_closer_than_the_safe_separation_while_the_conditions_hold(
    kind: str, outcomes: dict[str, list[Outcome]]
) -> None:
    kept = [outcome.least for outcome in outcomes[kind] if not outcome.is_broken]
    assert len(outcomes[kind]) == SHORT[kind]
    assert min(kept, default=SAFE) >= SAFE
    assert bool(kept) == (kind not in BREAKING)


@pytest.mark.slow
@pytest.mark.parametrize("kind", sorted(set(SHORT) - set(WITHOUT_GOALS)))
def test_robots_that_keep_apart_arrive(kind: str, outcomes: dict[str, list[Outcome]]) -> None:
    assert all(isfinite(outcome.arrived) for outcome in outcomes[kind])


@pytest.mark.slow
def test_the_filter_acts_in_these_runs(outcomes: dict[str, list[Outcome]]) -> None:
    least = [outcome.least for of_kind in outcomes.values() for outcome in of_kind if not outcome.is_broken]
    assert len([separation for separation in least if separation < 6.0]) > 10


@pytest.mark.slow
def test_controllers_that_drive_face_to_face_are_kept_apart_and_block_each_other() -> None:
    team = Team("pull", np.array([[-15.0, 0.0, 0.0], [15.0, 0.0, pi]]), np.array([[15.0, 0.0], [-15.0, 0.0]]), {})
    pulled = Batch([team], longest=16.0)
    registry.use(drivers.__name__)
    try:
        controller = {"use": f"{drivers.__name__}:Driver", "goals": placed(pulled)[1].tolist()}
        driven = Batch(
            [team], tables={"robots": {"poses": placed(pulled)[0].tolist(), "controller": controller}}, longest=16.0
        )
        (blocked,), (passed,) = run(driven), run(pulled)
    finally:
        registry.withdraw(drivers.__name__)
    assert SAFE <= blocked.least < 5.2
    assert not isfinite(blocked.arrived)
    assert passed.least >= SAFE
    assert isfinite(passed.arrived)


@pytest.mark.slow
@pytest.mark.parametrize(("speed", "length"), [(2.0, 100.0), (5.0, 400.0), (10.0, 400.0), (20.0, 400.0)])
def test_two_lanes_that_cross_at_a_shallow_angle_keep_the_safe_separation(speed: float, length: float) -> None:
    (outcome,) = run(lanes(speed, length, 150.0))
    assert not outcome.is_broken
    assert outcome.least >= SAFE
    assert isfinite(outcome.arrived)


@pytest.mark.slow
@pytest.mark.parametrize("speed", [5.0, 10.0])
def test_without_the_spread_of_places_the_same_lanes_collide(speed: float, monkeypatch: pytest.MonkeyPatch) -> None:
    # The first form bounded only the speed toward the place where a peer was last heard (s_j = 0).
    corrected = separation.near

    def first_form(*arguments: object) -> Near | None:
        near = corrected(*arguments)  # type: ignore[arg-type]
        return None if near is None else near._replace(spread=np.zeros_like(near.spread))

    monkeypatch.setattr(separation, "near", first_form)
    (outcome,) = run(lanes(speed, 400.0, 0.6 * 400.0 / speed))  # they cross half-way
    assert not outcome.is_broken
    assert outcome.least < 0.01


@pytest.mark.slow
def test_without_the_filter_the_robots_of_a_circle_collide() -> None:
    scenario = loop.load("swap.toml", run__duration=13.0)
    unfiltered = scenario.formation.model_copy(update={"safe_separation": None})
    free = scenario.model_copy(update={"formation": unfiltered})
    assert closest(loop.run(free).poses) < 0.5
    assert closest(loop.run(scenario).poses) >= SAFE


@pytest.mark.slow
def test_the_digits_of_a_swap_do_not_depend_on_the_crews() -> None:
    scenario = loop.load("swap.toml", run__duration=13.0)
    together, apart = loop.run(scenario), loop.run(scenario, split=[[0, 3, 4], [1], [2, 5]])
    assert np.array(together.poses).tobytes() == np.array(apart.poses).tobytes()
    assert closest(together.poses) < 10.0  # so that the filter acts


def closest(poses: list[Floats]) -> float:
    """Smallest separation of two robots at any tick [m]."""
    places = np.array(poses)[:, :, :2]
    apart = places[:, :, None] - places[:, None]
    upper = np.triu_indices(places.shape[1], 1)
    return float(np.hypot(apart[..., 0], apart[..., 1])[:, upper[0], upper[1]].min())
