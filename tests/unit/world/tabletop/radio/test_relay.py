"""The fate of each datagram, from positions and draws."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fes.errors import ScenarioError
from tests.support import loop
from world.tabletop.radio.reachability import MAX_ROBOTS, Reach, Reachability
from world.tabletop.radio.relay import Relay


def reach(*positions: tuple[float, float]) -> Reach:
    poses = [(*position, 0.0) for position in positions]
    return Reachability(loop.load("tabletop.toml", robots__poses=poses)).measure(np.array(poses), 0.0)


def test_the_probability_is_that_of_the_channel_at_the_true_separation_in_both_directions() -> None:
    seen = reach((0.0, 0.0), (75.0, 0.0), (0.0, 149.0))
    assert seen.probability[0, 1] == pytest.approx(math.exp(-3e-7 * 75.0**3))  # (3) with the paper's numbers
    assert seen.probability[2, 0] == seen.probability[0, 2] == pytest.approx(math.exp(-3e-7 * 149.0**3))
    assert seen.in_range.tolist() == [[False, True, True], [True, False, False], [True, False, False]]  # 166.8 m
    assert seen.probability[1, 2] == 0.0


def test_a_relay_refuses_a_channel_with_a_memory_and_a_crowd() -> None:
    bursts = {"channel__bursts": {"bad_share": 0.2, "mean_length": 0.5}}
    with pytest.raises(ScenarioError, match=r"^channel.bursts: a table has none"):
        Reachability(loop.load("tabletop.toml", **bursts))
    crowd = [(10.0 * robot, 0.0, 0.0) for robot in range(MAX_ROBOTS + 1)]
    with pytest.raises(ScenarioError, match=r"^robots: .* at most 100 robots, got 101"):
        Reachability(loop.load("tabletop.toml", robots__poses=crowd))


def test_a_datagram_reaches_those_whose_draw_is_below_the_probability_and_whose_address_is_known() -> None:
    relay: Relay[str] = Relay(4, reach((0.0, 0.0), (75.0, 0.0), (0.0, 75.0), (0.0, 149.0)))
    draws = np.array([0.0, 0.88, 0.89, 0.36])  # probabilities of 0.881 and 0.371
    assert relay.receivers(0, "zero", draws) == []  # no other robot is known yet
    for robot, name in ((1, "one"), (2, "two"), (3, "three")):
        relay.receivers(robot, name, np.ones(4))
    assert relay.receivers(0, "zero", draws) == ["one", "three"]
    assert relay.sent[0].tolist() == [0, 1, 1, 1]
    assert relay.forwarded[0].tolist() == [0, 1, 0, 1]


def test_a_robot_that_restarts_is_reached_at_its_new_address() -> None:
    relay: Relay[str] = Relay(2, reach((0.0, 0.0), (1.0, 0.0)))
    relay.receivers(1, "before", np.zeros(2))
    relay.receivers(1, "after", np.zeros(2))
    assert relay.receivers(0, "zero", np.zeros(2)) == ["after"]


@pytest.mark.parametrize("sender", [None, 2, 2**31, -1])
def test_a_datagram_of_no_robot_of_the_team_teaches_no_address_and_goes_nowhere(sender: int | None) -> None:
    relay: Relay[str] = Relay(2, reach((0.0, 0.0), (1.0, 0.0)))
    relay.receivers(0, "zero", np.zeros(2))
    assert relay.receivers(sender, "stranger", np.zeros(2)) == []
    assert relay.receivers(1, "one", np.zeros(2)) == ["zero"]
    assert relay.foreign == 1


@given(st.lists(st.tuples(st.floats(-200, 200), st.floats(-200, 200)), min_size=2, max_size=6), st.integers(0, 2**32))
@settings(max_examples=50, deadline=None)
def test_no_datagram_crosses_the_communication_range_or_returns_to_its_sender(
    positions: list[tuple[float, float]], seed: int
) -> None:
    relay: Relay[int] = Relay(len(positions), reach(*positions))
    numbers = np.random.default_rng(seed)
    for sender in [*range(len(positions))] * 2:
        for receiver in relay.receivers(sender, sender, numbers.random(len(positions))):
            assert receiver != sender
            assert math.dist(positions[sender], positions[receiver]) <= 150.0
    assert (relay.forwarded <= relay.sent).all()
