"""Shapes: the patches of the triangular lattice, the drawn shapes, and how much quality weighs in each."""

import itertools
import math

import numpy as np
import pytest

from fes.arrays.types import Bools
from fes.shapes import routes
from fes.shapes.choice import shape
from fes.shapes.patch import patch
from fes.shapes.shape import of_slots

LINKS = (1, 3, 5, 7, 9, 12, 14, 16, 19, 21, 24, 24, 27, 30, 33, 35, 37, 40, 43)
"""Links of the best patches of 2 to 20 robots."""

WEIGHTS = {2: 1.0, 3: 0.5, 5: 0.5952, 10: 0.5117, 13: 0.5786, 20: 0.5875, 37: 0.6978, 50: 0.7757, 100: 1.0052}
"""beta of some patches, for one loss."""


def hops_by_search(is_link: Bools, lost: int | None = None) -> float:
    """Mean number of hops between two robots, by breadth-first search from each one."""
    robots = [robot for robot in range(len(is_link)) if robot != lost]
    counts = []
    for start in robots:
        depth, front = {start: 0}, [start]
        for robot in front:  # which grows meanwhile
            for peer in robots:
                if is_link[robot, peer] and peer not in depth:
                    depth[peer] = depth[robot] + 1
                    front.append(peer)
        if len(depth) < len(robots):
            return math.inf
        counts += [depth[robot] for robot in robots if robot != start]
    return sum(counts) / len(counts)


@pytest.mark.parametrize(("n", "links"), list(enumerate(LINKS, start=2)))
def test_a_patch_has_the_links_of_the_best_known_one(n: int, links: int) -> None:
    assert patch(n, 1).links == links


@pytest.mark.parametrize(("n", "weight"), list(WEIGHTS.items()))
def test_a_patch_has_the_quality_weight_of_its_hops_and_neighbors(n: int, weight: float) -> None:
    assert patch(n, 1).quality_weight(1, 1.0) == pytest.approx(weight, abs=5e-5)


def test_the_quality_weight_of_ten_robots_is_exact() -> None:
    assert patch(10, 1).quality_weight(1, 1.0) == pytest.approx((35 / 18) / 3.8, rel=1e-15)
    assert patch(10, 1).quality_weight(1, 4.0) == pytest.approx((35 / 18) / 3.8 / 4.0, rel=1e-15)


@pytest.mark.parametrize("n", [3, 4, 7, 10, 13])
def test_hops_agree_with_a_search(n: int) -> None:
    team = patch(n, 1)
    assert team.hops(0) == pytest.approx(hops_by_search(team.is_link))
    assert team.hops(1) == pytest.approx(max(hops_by_search(team.is_link, lost) for lost in range(n)))


@pytest.mark.parametrize("n", range(1, 31))
def test_the_sites_of_a_patch_are_those_of_a_unit_lattice_about_their_mean(n: int) -> None:
    slots = patch(n, 1).slots
    np.testing.assert_allclose(slots.sum(axis=0), 0.0, atol=1e-12)
    from_first = slots - slots[0]
    v = from_first[:, 1] / (math.sqrt(3.0) / 2.0)
    u = from_first[:, 0] - 0.5 * v
    np.testing.assert_allclose([u, v], np.round([u, v]), atol=1e-9)
    assert len({(round(a), round(b)) for a, b in zip(u, v, strict=True)}) == n


@pytest.mark.parametrize("n", range(3, 31))
def test_no_loss_of_a_robot_cuts_a_patch(n: int) -> None:
    is_link = patch(n, 1).is_link
    for lost in range(n):
        rest = np.delete(np.delete(is_link, lost, 0), lost, 1)
        assert routes.reaches_all(rest)


def test_a_ring_a_ladder_and_a_line_weigh_quality_more() -> None:
    weights = {name: shape(name, 10, 1).quality_weight(1, 1.0) for name in ("line", "ring", "ladder")}
    assert weights == pytest.approx({"line": 2.037, "ring": 1.667, "ladder": 1.026}, abs=5e-4)
    # the loss of an inner robot parts a line: only the losses that leave routes count
    assert shape("line", 10, 1).hops(1) == shape("line", 10, 1).hops(0) == pytest.approx(11 / 3)


@pytest.mark.parametrize("n", [1, 2, 3, 4, 9, 10])
@pytest.mark.parametrize("name", ["lattice", "line", "ring", "ladder"])
def test_every_shape_connects_its_robots_by_unit_links(name: str, n: int) -> None:
    team = shape(name, n, 1)
    assert team.slots.shape == (n, 2)
    assert routes.reaches_all(team.is_link)
    for i, j in itertools.combinations(range(n), 2):
        distance = math.dist(team.slots[i], team.slots[j])
        assert distance > 1.0 - 1e-9
        assert team.is_link[i, j] == (distance < 1.0 + 1e-9), (i, j, distance)


def test_offsets_are_used_in_their_order() -> None:
    offsets = ((0.0, 0.0), (1.0, 0.0), (2.0, 0.05), (2.0, 1.0))
    team = shape("offsets", 3, 1, offsets)
    np.testing.assert_allclose(team.slots - team.slots[0], offsets[:3])
    assert team.links == 2
    with pytest.raises(ValueError, match="5 robots need 5 offsets, got 4"):
        shape("offsets", 5, 1, offsets)


def test_two_robots_seek_the_paper_s_optimum_with_and_without_losses() -> None:
    for name in ("lattice", "line", "ring", "ladder"):
        for losses in (0, 1):
            assert shape(name, 2, losses).quality_weight(losses, 1.0) == 1.0
    assert of_slots(np.zeros((1, 2))).links == 0


def test_routes_find_what_is_not_connected() -> None:
    is_link = np.zeros((4, 4), dtype=np.bool_)
    is_link[0, 1] = is_link[1, 0] = is_link[2, 3] = is_link[3, 2] = True
    assert not routes.reaches_all(is_link)
    is_link[1, 2] = is_link[2, 1] = True
    assert routes.reaches_all(is_link)
