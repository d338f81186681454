"""Robots without a world, at clocks of their own, find the optimum as those of the simulated world do."""

import numpy as np
import pytest

from tests.support import loop
from tests.support.unsynchronized import OPTIMUM, SETTLED, Team

DURATION, SEED = 30.0, 1
"""From SETTLED on this is one period of the dither."""


@pytest.fixture(scope="module")
def team() -> Team:
    team = Team(loop.load("measured.toml", run__seed=SEED), SEED)
    team.run(DURATION)
    return team


def test_the_estimates_have_the_bias_of_the_lockstep_world(team: Team) -> None:
    """Seeds of the lockstep world differ by 0.43 m. Counting by the last step's window instead adds 1 m and more:
    jitter leaves 9 % of windows empty, which looks like loss."""
    world = loop.load("measured.toml", run__seed=SEED)
    history = loop.run(world, round(DURATION / world.run.dt))
    later = history.estimates[round(SETTLED / world.run.dt) :]
    bias = np.mean([np.mean(list(estimates.values())) for estimates in later]) - OPTIMUM
    assert abs(team.bias(SETTLED) - bias) <= 0.43
    assert abs(team.bias(SETTLED)) <= 0.5


def test_every_beacon_that_the_channel_lets_pass_counts_once(team: Team) -> None:
    links = [counts for senses in team.senses for counts in senses.counts.values()]
    assert sum(counts.late + counts.early + counts.repeated for counts in links) == 0
    before_the_first_step = sum(counts.skipped for counts in links)
    counted = sum(counts.heard + counts.removed for counts in links) + before_the_first_step
    unfinished = 3 * len(links)  # at the end of the run: on the air or waiting for a step
    assert counted > 10_000
    assert before_the_first_step < 10
    assert 0 <= team.delivered - counted <= unfinished


def test_a_rule_that_expects_the_number_of_the_last_own_tick_throws_most_beacons_away(team: Team) -> None:
    assert team.heard > 10_000
    assert team.strict < team.heard / 2


def test_clocks_of_their_own_change_the_measured_separations_by_less_than_four_centimeters(team: Team) -> None:
    """A beacon's own slot lies up to a tick from the moment it was sent: 20 ms, at 2 m/s. The mean is nought."""
    assert len(team.by_slot) > 1000
    assert np.abs(team.by_slot).max() <= 0.04
    assert abs(np.mean(team.by_slot)) <= 0.002
    assert np.std(team.by_reception) < np.std(team.by_slot)
