"""Checks of the values that an extension returns: one line names the extension, the rule and the value."""

from typing import Any

import numpy as np
import pytest

from fes.arrays.types import Floats, read_only
from fes.errors import FesError
from fes.extension import Contacts, Formed, LinkGeometry, Neighborhood, Published, Table
from fes.extension.kinds import DYNAMICS, FORMATION, RULE, SEEKING, Kind
from fes.extension.protocols import NoParameters
from tests.support import surroundings

N = 3
AROUND = surroundings.around(np.array([[0.0, 0.0], [60.0, 0.0], [0.0, 60.0]]))


class Stub:
    """An extension that returns what it is given."""

    Parameters: type[Table] = NoParameters
    declared = statistics = 0
    details: tuple[str, ...] = ()
    learnt: tuple[str, ...] = ()

    def __init__(self, result: Any = None, **stated: Any) -> None:
        self.result = result
        vars(self).update(stated)

    def __call__(self, contacts: Contacts) -> Any:
        return self.result

    def step(self, state: Any, around: Neighborhood, links: LinkGeometry) -> Any:
        return self.result


def checked(kind: Kind, stub: Any, context: Any = None) -> Any:
    return kind.checked(stub, f"{kind.name} 'stub'", context or surroundings.context(N))


def refusal(kind: Kind, stub: Any, *arguments: Any) -> str:
    with pytest.raises(FesError) as caught:
        checked(kind, stub).step(*arguments)
    return str(caught.value).removeprefix(f"{kind.name} 'stub': ")


@pytest.mark.parametrize(
    ("kind", "stated", "message"),
    [
        (SEEKING, {"statistics": 65}, "`statistics` must be a whole number from 0 to 64, got 65"),
        (SEEKING, {"declared": 257}, "`declared` must be a whole number from 0 to 256, got 257"),
        (SEEKING, {"learnt": ("a",) * 17}, "`learnt` must hold at most 16 names, got 17"),
        (FORMATION, {"details": ("a",) * 65}, "`details` must hold at most 64 names, got 65"),
        (FORMATION, {"declared": True}, "`declared` must be a whole number from 0 to 256, got True"),
    ],
)
def test_a_class_states_no_more_than_a_message_holds(kind: Kind, stated: dict[str, Any], message: str) -> None:
    assert refusal(kind, Stub(**stated)) == message


@pytest.mark.parametrize(
    ("twists", "message"),
    [
        ([[0.0, 0.0]] * N, "the twists must be an array of shape [3, 2], got list"),
        (np.full((N, 2), np.inf), "the twists must be finite, got inf"),
        (np.zeros((N, 3)), "the twists must have shape [3, 2], got [3, 3]"),
    ],
)
def test_twists_are_checked_as_they_are(twists: Any, message: str) -> None:
    assert refusal(FORMATION, Stub(Formed(None, np.zeros((N, 2)), twists=twists)), None, AROUND, None) == message


@pytest.mark.parametrize(
    ("weight", "message"),
    [
        (np.ones(N + 1), "the quality weight must have shape [3], got [4]"),
        (np.full(N, np.nan), "the quality weight must be finite, got nan"),
        (np.array([1.0, 0.0, -2.0]), "the quality weight must be positive, got 0"),
    ],
)
def test_quality_weights_are_checked(weight: Any, message: str) -> None:
    formed = Formed(None, np.zeros((N, 2)), quality_weight=weight)
    assert refusal(FORMATION, Stub(formed), None, AROUND, None) == message


def test_a_twist_that_is_not_a_number_leaves_the_pull_in_force() -> None:
    formed = Formed(None, np.zeros((N, 2)), twists=np.full((N, 2), np.nan))
    assert checked(FORMATION, Stub(formed)).step(None, AROUND, None) is formed


def test_a_matrix_is_rejected() -> None:
    pull = np.zeros((N, 2)).view(np.matrix)
    message = "the pull must be an array of shape [3, 2], got matrix"
    assert refusal(FORMATION, Stub(Formed(None, pull)), None, AROUND, None) == message


def test_a_rule_cannot_select_a_peer_that_is_no_longer_known() -> None:
    m = len(AROUND.contacts.edges)
    known = np.arange(m) % 2 == 0
    contacts = AROUND.contacts._replace(known=known)
    assert checked(RULE, Stub(np.ones(m, dtype=np.bool_)))(contacts).tolist() == known.tolist()


class InPlace:
    """Bodies that move within one buffer."""

    Parameters = NoParameters

    def start(self, poses: Floats) -> Floats:
        return poses.copy()

    def step(self, state: Floats, twists: Floats, dt: float) -> Floats:
        state[:, 0] += dt * twists[:, 0]
        return state

    def poses(self, state: Floats) -> Floats:
        return state


class Robots:
    robots = N


def test_bodies_that_step_in_place_leave_the_poses_of_the_tick_before() -> None:
    bodies = checked(DYNAMICS, InPlace(), Robots())
    state = bodies.start(np.zeros((N, 3)))
    before = bodies.poses(state)
    after = bodies.poses(bodies.step(state, np.ones((N, 2)), 0.5))
    assert (before[0, 0], after[0, 0]) == (0.0, 0.5)


def test_the_first_poses_of_bodies_are_checked_too() -> None:
    bodies = checked(DYNAMICS, InPlace(), Robots())
    with pytest.raises(FesError, match=r"^dynamics 'stub': the poses must have shape \[3, 3\], got \[2, 3\]$"):
        bodies.poses(np.zeros((2, 3)))


def test_a_read_only_array_shares_its_values_and_cannot_be_written_to() -> None:
    values = np.zeros(2)
    seen = read_only(values)
    values[0] = 1.0
    assert seen[0] == 1.0
    with pytest.raises(ValueError, match="read-only"):
        seen[0] = 2.0


def test_the_numbers_that_a_seeking_law_publishes_have_the_declared_shapes() -> None:
    class Law(Stub):
        def publish(self, state: Any, links: Any) -> Any:
            return self.result

    law = checked(SEEKING, Law(Published(np.zeros(6), np.zeros((N, 1)), np.zeros((0, 6)))))
    with pytest.raises(FesError, match=r"the statistics must have shape \[3, 0\], got \[3, 1\]$"):
        law.publish(None, AROUND.links)


def test_the_estimates_of_a_law_with_a_physical_dither_are_checked_and_those_of_others_are_not_asked_for() -> None:
    class Law(Stub):
        def estimates(self, state: Any, links: Any) -> Any:
            return self.result

    assert not hasattr(checked(SEEKING, Stub()), "estimates")
    assert checked(SEEKING, Law(np.ones(6))).estimates(None, AROUND.links).tolist() == [1.0] * 6
    with pytest.raises(FesError, match=r"the estimates must have shape \[6\], got \[5\]$"):
        checked(SEEKING, Law(np.ones(5))).estimates(None, AROUND.links)
