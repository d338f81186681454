"""The alpha-lattice against the formulas of the article in scalar code."""

import math

import numpy as np
import pytest

from agents.rivals.alpha_lattice import AlphaLattice, AlphaLatticeParameters
from tests.support.surroundings import DT, around, context, geometry, pair

REST = np.zeros((2, 2), dtype="<f4").tobytes()


def law(force: float = 0.1, consensus: float = 0.6, friction: float = 0.0) -> AlphaLattice:
    parameters = AlphaLatticeParameters(
        spacing=70.0, range_ratio=1.2, force_gain=force, consensus_gain=consensus, friction=friction
    )
    return AlphaLattice(parameters, context(2))


def norm(z: float) -> float:
    """The sigma-norm with epsilon = 0.1."""
    return (math.sqrt(1.0 + 0.1 * z * z) - 1.0) / 0.1


def bump(z: float) -> float:
    """rho_h of the article, h = 0.2."""
    if z < 0.2:
        return 1.0
    return 0.5 * (1.0 + math.cos(math.pi * (z - 0.2) / 0.8)) if z <= 1.0 else 0.0


def force(z: float) -> float:
    """phi_alpha(|z|_sigma) times the length of n_ij, for a = b = 5."""
    excess = norm(z) - norm(70.0)
    return bump(norm(z) / norm(84.0)) * 5.0 * excess / math.sqrt(1.0 + excess**2) * z / math.sqrt(1.0 + 0.1 * z * z)


@pytest.mark.parametrize("separation", [10.0, 60.0, 69.0, 75.0, 83.0])
def test_the_force_is_that_of_the_article(separation: float) -> None:
    seen = around(pair(separation), declared=REST)
    velocity = law().step(np.zeros((2, 2)), seen, geometry(seen, 70.0)).state
    assert velocity[0, 0] == pytest.approx(DT * 0.1 * force(separation), rel=1e-12)
    assert velocity[1].tolist() == [-velocity[0, 0], 0.0]


@pytest.mark.parametrize("separation", [70.0, 84.0, 100.0])
def test_no_force_acts_at_the_spacing_and_beyond_the_range(separation: float) -> None:
    seen = around(pair(separation), declared=REST)
    assert not law().step(np.zeros((2, 2)), seen, geometry(seen, 70.0)).pull.any()


def test_a_robot_takes_over_the_velocity_that_its_peer_put_into_its_beacon() -> None:
    declared = np.array([[0.0, 0.0], [1.5, -0.5]], dtype="<f4").tobytes()
    seen = around(pair(70.0), declared=declared)
    own = np.array([[1.0, 2.0], [0.0, 0.0]])
    formed = law().step(own, seen, geometry(seen, 70.0))
    share = 0.6 * bump(norm(70.0) / norm(84.0)) * DT
    assert formed.state[0] == pytest.approx([1.0 + share * (1.5 - 1.0), 2.0 + share * (-0.5 - 2.0)], rel=1e-12)
    assert formed.declared is not None
    assert formed.declared.tobytes() == formed.state.astype("<f4").tobytes()


def test_friction_alone_slows_a_robot_down() -> None:
    moving = np.array([[2.0, 0.0], [0.0, 0.0]])
    seen = around(pair(500.0), declared=REST)
    formed = law(friction=0.5).step(moving, seen, geometry(seen, 70.0))
    assert formed.pull[0].tolist() == [2.0 * (1.0 - 0.5 * DT), 0.0]


def test_a_restarted_robot_is_at_rest() -> None:
    state = law().forget(np.ones((2, 2)), np.array([True, False]))
    assert state.tolist() == [[0.0, 0.0], [1.0, 1.0]]


def test_bytes_that_are_not_a_number_count_as_rest() -> None:
    seen = around(pair(70.0), declared=b"\xff" * 16)
    assert not law().step(np.zeros((2, 2)), seen, geometry(seen, 70.0)).pull.any()
