"""The filter that keeps robots apart, against the same steps robot by robot, and against every place of a peer."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.control import separation
from agents.control.separation import Near
from fes.arrays.types import Floats
from fes.extension.protocols import Formed
from fes.model import kinematics
from fes.model.config import FormationConfig
from fes.model.contacts import Contacts
from fes.model.sensing import Sensed
from tests.support import layouts

DT, LIMIT, SAFE = 0.02, 5.0, 5.0
CONFIG = FormationConfig(linear_limit=LIMIT, safe_separation=SAFE, linear_gain=2.0, separation_gain=0.8)
FREE = FormationConfig(linear_limit=LIMIT)

headings = st.floats(-math.pi, math.pi)
unit_interval = st.floats(0.0, 1.0)


def aged(where: Floats, age: int, decoded: list[bool] | None = None) -> tuple[Contacts, Sensed]:
    """The places of each other that robots know, `where` [n, 3], by beacons of `age` ticks ago."""
    contacts = layouts.hear(where, range(len(where)))
    known = contacts.known if decoded is None else contacts.known & np.array(decoded)
    return contacts._replace(known=known), Sensed(age, where)


def peers(where: Floats, age: int = 1) -> Near:
    result = separation.near(*aged(where, age), DT, CONFIG)
    assert result is not None
    return result


def crowd(seed: int, n: int, width: float) -> tuple[Floats, Floats]:
    """Poses and pulls."""
    rng = np.random.default_rng(seed)
    return layouts.scatter(rng, n, width), rng.normal(0.0, 6.0, (n, 2))


def witness(where: Floats, pull: Floats, age: int) -> list[tuple[float, float]]:
    """Steps 1 and 2, for one robot after the other."""
    gain, rate, longest = CONFIG.linear_gain, CONFIG.separation_gain, LIMIT / CONFIG.linear_gain

    def clipped(x: float, y: float) -> tuple[float, float]:
        size = math.hypot(x, y)
        return (x, y) if size <= longest else (x * longest / size, y * longest / size)

    result = []
    for i in range(len(where)):
        close = []
        for j in range(len(where)):
            d = layouts.distance(where, i, j)
            reach = LIMIT * age * DT
            if j != i and d < SAFE + 2.0 * LIMIT / rate + reach:
                u = (where[j, :2] - where[i, :2]) / d
                close.append((u[0], u[1], max(0.0, rate / 2.0 * (d - SAFE - reach)), min(1.0, reach / d)))
        gx, gy = clipped(*pull[i])
        add_x = add_y = 0.0
        for ux, uy, b, _ in close:
            excess = max(0.0, gain * (gx * ux + gy * uy) - b) * CONFIG.give_way_gain / gain
            add_x, add_y = add_x + excess * uy, add_y - excess * ux  # R(-90 degrees) u = (u_y, -u_x)
        gx, gy = gx + add_x, gy + add_y
        for _ in range(3):
            for ux, uy, b, s in close:
                excess = max(0.0, gain * (gx * ux + gy * uy + s * math.hypot(gx, gy)) - b) / gain
                gx, gy = gx - excess * ux, gy - excess * uy
        result.append(clipped(gx, gy))
    return result


@pytest.mark.parametrize("age", [1, 7])
@pytest.mark.parametrize(("seed", "n", "width"), [(1, 2, 8.0), (2, 6, 20.0), (3, 12, 30.0), (4, 30, 200.0)])
def test_the_pull_is_that_of_the_same_steps_robot_by_robot(seed: int, n: int, width: float, age: int) -> None:
    where, pull = crowd(seed, n, width)
    filtered = separation.give_way(Formed(None, pull), peers(where, age), CONFIG).pull
    assert filtered == pytest.approx(np.array(witness(where, pull, age)), abs=1e-12)  # roundings of some meters
    assert np.abs(filtered - pull).max() > 0.1


def test_two_robots_face_to_face_give_way_to_the_right() -> None:
    where = np.array([[0.0, 0.0, 0.0], [8.0, 0.0, math.pi]])
    filtered = separation.give_way(Formed(None, np.array([[9.0, 0.0], [-9.0, 0.0]])), peers(where), CONFIG).pull
    assert filtered[0, 1] < -0.5  # looking along +x, the right is -y
    assert filtered[1, 1] > 0.5


def test_without_a_safe_separation_nothing_changes() -> None:
    where, pull = crowd(1, 5, 10.0)
    formed, twists = Formed(None, pull), np.ones((5, 2))
    none = separation.near(*aged(where, 1), DT, FREE)
    assert none is None
    assert separation.give_way(formed, none, FREE) is formed
    is_new = np.ones(5, dtype=np.bool_)
    assert separation.slow_down(twists, none, where[:, 2], is_new, DT, FREE) is twists


def test_a_pull_that_is_short_enough_is_unchanged_far_from_all_peers() -> None:
    where = layouts.poses([(0.0, 0.0), (100.0, 0.0)])
    pull = np.array([[2.5, 0.0], [6.0, 8.0]])  # m; at 2 /s, 2.5 m is 5 m/s
    near = peers(where)
    assert len(near.edges) == 0
    filtered = separation.give_way(Formed(None, pull), near, CONFIG).pull
    assert filtered.tolist() == [[2.5, 0.0], [1.5, 2.0]]


def test_only_peers_that_are_known_bound_a_robot() -> None:
    where = layouts.poses([(0.0, 0.0), (6.0, 0.0)])
    contacts, sensed = aged(where, 1, [True, False])
    near = separation.near(contacts, sensed, DT, CONFIG)
    assert near is not None
    assert layouts.pairs_of(near.edges) == {(0, 1)}
    # (gamma / 2) (d - d_safe - v_max tau h) and v_max tau h / d, by hand
    assert near.bound == pytest.approx([0.4 * (6.0 - 5.0 - 0.1)], rel=1e-14)
    assert near.spread == pytest.approx([0.1 / 6.0], rel=1e-14)


def test_the_deviation_of_both_ends_is_added_to_the_safe_separation() -> None:
    where = layouts.poses([(0.0, 0.0), (9.0, 0.0)])
    contacts, sensed = aged(where, 1, [True, False])
    near = separation.near(contacts, sensed._replace(deviation=np.array([0.6, 0.0])), DT, CONFIG)
    assert near is not None
    # as above, with a safe separation of 5 m and the root of 0.6^2 + 0.6^2
    assert near.bound == pytest.approx([0.4 * (9.0 - 5.0 - math.sqrt(0.72) - 0.1)], rel=1e-14)


def test_the_own_pose_is_that_of_this_tick_and_not_that_of_the_beacons() -> None:
    where = layouts.poses([(0.0, 0.0), (30.0, 0.0)])
    contacts, _ = aged(where, 1)
    assert separation.near(contacts, Sensed(1, where), DT, CONFIG).edges.peers.tolist() == []  # type: ignore[union-attr]
    moved = where + np.array([[20.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    near = separation.near(contacts, Sensed(1, moved), DT, CONFIG)
    assert near is not None
    assert layouts.pairs_of(near.edges) == {(0, 1)}


def test_robots_at_one_place_drive_apart_or_stand() -> None:
    where = layouts.poses([(1.0, 1.0), (1.0, 1.0)])
    near = peers(where)
    assert (near.x.tolist(), near.y.tolist(), near.bound.tolist()) == ([1.0, -1.0], [0.0, 0.0], [0.0, 0.0])
    free = np.array([[5.0, 0.3], [-5.0, -0.3]])
    slowed = separation.slow_down(free, near, where[:, 2], np.zeros(2, dtype=np.bool_), DT, CONFIG)
    assert np.abs(slowed[:, 0]).tolist() == [0.0, 0.0]
    assert slowed[:, 1].tolist() == [0.3, -0.3]


def test_a_robot_that_has_just_started_does_not_drive() -> None:
    where = layouts.poses([(0.0, 0.0), (100.0, 0.0)])
    slowed = separation.slow_down(
        np.array([[2.0, 1.0], [2.0, 1.0]]), peers(where), where[:, 2], np.array([True, False]), DT, CONFIG
    )
    assert slowed.tolist() == [[0.0, 1.0], [2.0, 1.0]]


@given(
    distance=st.floats(0.01, 20.0),
    bearing=headings,
    heading=headings,
    linear=st.floats(-LIMIT, LIMIT),
    angular=st.floats(-900.0, 900.0),
    age=st.integers(1, 200),
    places=st.lists(st.tuples(headings, unit_interval), min_size=1, max_size=40),
)
def test_no_twist_closes_too_fast_toward_any_place_where_the_peer_can_be(
    distance: float,
    bearing: float,
    heading: float,
    linear: float,
    angular: float,
    age: int,
    places: list[tuple[float, float]],
) -> None:
    # The witness moves the body itself; up to 900 rad/s, a body turns by 18 rad in a tick.
    own = np.array([0.0, 0.0, heading])
    peer = np.array([distance * math.cos(bearing), distance * math.sin(bearing), 0.0])
    where = np.stack([own, peer])
    none = np.zeros(2, dtype=np.bool_)
    free = np.array([[linear, angular], [0.0, 0.0]])
    slowed = separation.slow_down(free, peers(where, age), where[:, 2], none, DT, CONFIG)
    assert abs(slowed[0, 0]) <= abs(linear)
    moved = kinematics.move(where, slowed, DT)[0, :2]
    reach = LIMIT * age * DT
    for angle, share in [(0.0, 0.0), *places]:
        place = peer[:2] + share * reach * np.array([math.cos(angle), math.sin(angle)])
        away = math.hypot(*place)
        if away > SAFE:
            closed = float(moved @ place) / away
            assert closed <= DT * 0.4 * (away - SAFE) + 1e-12  # (gamma / 2) (d - d_safe); roundings of 0.1 m


def test_the_speed_is_bounded_no_more_than_needed() -> None:
    # Straight at the peer: exactly b. Across, as far as the peer's reach allows: b over the cosine of the rest.
    where = np.array([[0.0, 0.0, 0.0], [9.0, 0.0, 0.0]])
    near, none = peers(where), np.zeros(2, dtype=np.bool_)
    b, sigma = 0.4 * (9.0 - 5.0 - 0.1), math.asin(0.1 / 9.0)
    for heading, wanted in ((0.0, b), (0.5 * sigma, b), (1.3, b / math.cos(1.3 - sigma)), (1.6, LIMIT), (3.0, LIMIT)):
        twists = np.array([[LIMIT, 0.0], [0.0, 0.0]])
        slowed = separation.slow_down(twists, near, np.array([heading, 0.0]), none, DT, CONFIG)
        assert slowed[0, 0] == pytest.approx(min(wanted, LIMIT), rel=1e-12)
        backward = separation.slow_down(-twists, near, np.array([heading + math.pi, 0.0]), none, DT, CONFIG)
        assert backward[0, 0] == pytest.approx(-min(wanted, LIMIT), rel=1e-12)


def test_a_robot_that_may_not_close_stands_with_a_zero_of_one_sign() -> None:
    # Processors differ in the sign of the smaller of two zeros, and a digest shows it.
    where = np.array([[0.0, 0.0, 0.0], [5.0, 0.0, 0.0]])
    none = np.zeros(2, dtype=np.bool_)
    for speed in (1.0, -1.0):
        slowed = separation.slow_down(np.full((2, 2), [speed, 0.0]), peers(where), np.zeros(2), none, DT, CONFIG)
        assert not np.signbit(slowed[slowed == 0.0]).any()
        assert 0.0 in slowed[:, 0]


@given(seed=st.integers(0, 200), n=st.integers(2, 14), age=st.integers(1, 30))
def test_the_digits_of_a_robot_do_not_depend_on_its_crew(seed: int, n: int, age: int) -> None:
    where, pull = crowd(seed, n, 25.0)
    together = filtered(where, pull, list(range(n)), age)
    for robot in range(n):
        alone = filtered(where, pull, [robot], age)
        assert alone.tobytes() == together[robot : robot + 1].tobytes()


def filtered(where: Floats, pull: Floats, robots: list[int], age: int) -> Floats:
    """The pulls, and the twists that follow from any free ones, of the `robots` of one crew [k, 4]."""
    own = where[robots]
    near = separation.near(layouts.hear(where, robots), Sensed(age, own), DT, CONFIG)
    way = separation.give_way(Formed(None, pull[robots]), near, CONFIG).pull
    new = np.zeros(len(robots), dtype=np.bool_)
    return np.hstack([way, separation.slow_down(pull[robots], near, own[:, 2], new, DT, CONFIG)])
