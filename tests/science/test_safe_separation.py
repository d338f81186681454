"""Robots keep their safe separation, whatever pulls them: the short form of `python -m tests.support.passing`."""

from collections.abc import Iterator
from math import isfinite, pi

import numpy as np
import pytest

from agents.control import separation
from agents.control.separation import Near
from fes.arrays.types import Floats
from fes.extension import registry
from tests.support import drivers, loop
from tests.support.passing import WITHOUT_GOALS
from tests.support.passing_kinds import COUNTS, batches
from tests.support.passing_runs import Batch, Outcome, Team, placed, run

SAFE = 5.0
BREAKING = {"one dies", "bursts, timeout 1 s", "one sends old places"}
"""Kinds of runs that do not keep the conditions; a few bursts of loss last for 5 s."""
BLOCKED = {"controllers"}


@pytest.fixture(scope="module")
def outcomes() -> Iterator[dict[str, list[Outcome]]]:
    """A run or two of each kind."""
    counts = {kind: 3 if kind == "pursuit" else 2 for kind in COUNTS}
    results = [outcome for batch in batches(counts, seed=5, longest=20.0) for outcome in run(batch)]
    yield {kind: [outcome for outcome in results if outcome.kind == kind] for kind in COUNTS}
    registry.withdraw(drivers.__name__)


def lanes(speed: float, length: float) -> Batch:
    """Two robots side by side, of which each wants to be on the side of the other one at the end of a long way."""
    starts = np.array([[0.0, 0.0, 0.5 * pi], [6.0, 0.0, 0.5 * pi]])
    team = Team("lanes", starts, np.array([[6.0, length], [0.0, length]]), {})
    return Batch([team], {"linear_limit": speed, "separation_gain": min(1.0, speed / SAFE)}, longest=250.0)


@pytest.mark.slow
@pytest.mark.parametrize("kind", COUNTS)
def test_no_two_robots_come_closer_than_the_safe_separation_while_the_conditions_hold(
    kind: str, outcomes: dict[str, list[Outcome]]
) -> None:
    assert len(outcomes[kind]) == 3 if kind == "pursuit" else 2
    assert min([outcome.least for outcome in outcomes[kind] if not outcome.is_broken], default=SAFE) >= SAFE
    kept = [outcome for outcome in outcomes[kind] if not outcome.is_broken]
    if kind not in BREAKING:
        assert kept or "bursts" in kind


@pytest.mark.slow
@pytest.mark.parametrize("kind", sorted(set(COUNTS) - set(WITHOUT_GOALS) - BLOCKED))
def test_robots_that_keep_apart_arrive(kind: str, outcomes: dict[str, list[Outcome]]) -> None:
    assert all(isfinite(outcome.arrived) for outcome in outcomes[kind])


@pytest.mark.slow
def test_controllers_that_drive_face_to_face_are_kept_apart_and_block_each_other() -> None:
    team = Team("pull", np.array([[-30.0, 0.0, 0.0], [30.0, 0.0, pi]]), np.array([[30.0, 0.0], [-30.0, 0.0]]), {})
    pulled = Batch([team], longest=40.0)
    registry.use(drivers.__name__)
    try:
        controller = {"use": f"{drivers.__name__}:Driver", "goals": placed(pulled)[1].tolist()}
        driven = Batch(
            [team], tables={"robots": {"poses": placed(pulled)[0].tolist(), "controller": controller}}, longest=40.0
        )
        (blocked,), (passed,) = run(driven), run(pulled)
    finally:
        registry.withdraw(drivers.__name__)
    assert SAFE <= blocked.least < 5.2
    assert not isfinite(blocked.arrived)
    assert passed.least >= SAFE
    assert passed.arrived < 40.0


@pytest.mark.slow
@pytest.mark.parametrize(("speed", "length"), [(2.0, 200.0), (5.0, 400.0), (10.0, 400.0), (20.0, 400.0)])
def test_two_lanes_that_cross_at_a_shallow_angle_keep_the_safe_separation(speed: float, length: float) -> None:
    (outcome,) = run(lanes(speed, length))
    assert not outcome.is_broken
    assert outcome.least >= SAFE
    assert isfinite(outcome.arrived)


@pytest.mark.slow
@pytest.mark.parametrize("speed", [5.0, 10.0, 20.0])
def test_without_the_spread_of_places_the_same_lanes_collide(speed: float, monkeypatch: pytest.MonkeyPatch) -> None:
    # The first form bounded only the speed toward the place where a peer was last heard (s_j = 0).
    corrected = separation.near

    def first_form(*arguments: object) -> Near | None:
        near = corrected(*arguments)  # type: ignore[arg-type]
        return None if near is None else near._replace(spread=np.zeros_like(near.spread))

    monkeypatch.setattr(separation, "near", first_form)
    (outcome,) = run(lanes(speed, 400.0))
    assert not outcome.is_broken
    assert outcome.least < 0.01


@pytest.mark.slow
def test_without_the_filter_the_robots_of_a_circle_collide() -> None:
    scenario = loop.load("swap.toml", run__duration=20.0)
    tables = {"safe_separation": None}
    free = scenario.model_copy(update={"formation": scenario.formation.model_copy(update=tables)})
    assert closest(loop.run(free).poses) < 0.5
    assert closest(loop.run(scenario).poses) >= SAFE


@pytest.mark.slow
def test_the_digits_of_a_swap_do_not_depend_on_the_crews() -> None:
    scenario = loop.load("swap.toml", run__duration=16.0)
    together, apart = loop.run(scenario), loop.run(scenario, split=[[0, 3, 4], [1], [2, 5]])
    assert np.array(together.poses).tobytes() == np.array(apart.poses).tobytes()
    assert closest(together.poses) < 10.0  # so that the filter acts


def closest(poses: list[Floats]) -> float:
    """Smallest separation of two robots at any tick [m]."""
    places = np.array(poses)[:, :, :2]
    apart = places[:, :, None] - places[:, None]
    upper = np.triu_indices(places.shape[1], 1)
    return float(np.hypot(apart[..., 0], apart[..., 1])[:, upper[0], upper[1]].min())
