"""A channel that changes during the run."""

import dataclasses

import numpy as np
import pytest

from fes.arrays.types import Floats
from tests.support import layouts
from tests.support.radios import EVERYTHING, Pair, ledger, stand, started, team
from world.config.radio import RadioConfig


def pairs_within(poses: Floats, reach: float) -> set[Pair]:
    apart = np.hypot(poses[:, None, 0] - poses[None, :, 0], poses[:, None, 1] - poses[None, :, 1])
    near = (apart <= reach) & ~np.eye(len(poses), dtype=np.bool_)
    return set(zip(*(side.tolist() for side in np.nonzero(near)), strict=True))


@pytest.mark.parametrize("n", [20, 90])  # with a list for ever, and with one that is looked after
def test_another_range_shows_at_the_next_tick_and_keeps_the_contacts_that_stay(n: int) -> None:
    poses = layouts.scatter(np.random.default_rng(1), n, 600.0)
    world, state = started(team([(x, y) for x, y, _ in poses.tolist()], model="perfect"))
    state = stand(world, state, 5)
    for reach in (60.0, 420.0, 150.0, 150.5):
        kept = set(ledger(state, "sent")) & pairs_within(poses, reach)
        ages = ledger(state, "age")
        change = state.channel.model_copy(update={"communication_range": reach})
        state = stand(world, dataclasses.replace(state, channel=change))
        assert layouts.pairs_of(state.radio.edges) == pairs_within(poses, reach)
        assert layouts.pairs_of(state.proximity.edges) == pairs_within(poses, reach)
        assert {pair: age - 1 for pair, age in ledger(state, "age").items() if age} == {p: ages[p] for p in kept}


def test_another_formula_acts_from_the_tick_of_its_change_on() -> None:
    scenario = team([(0, 0), (110, 0)])
    world, state = started(scenario)
    state = stand(world, state, 10)
    assert state.channel == scenario.channel
    deaf = state.channel.model_copy(update={"reference_snr": 1.0})  # (3): p = exp(-3 x 110^3) = 0
    after = stand(world, dataclasses.replace(state, channel=deaf), 20)
    assert after.decoded == state.decoded
    assert ledger(after, "gap")[0, 1] >= 20
    perfect = stand(world, dataclasses.replace(after, channel=RadioConfig(model="perfect")), 20)
    assert perfect.decoded == after.decoded + 40


def test_a_change_and_its_reversal_leave_the_draws_of_the_other_ticks_alone() -> None:
    scenario = team([(0, 0), (110, 0), (60, 90)])
    world, state = started(scenario)
    other_world, other = started(scenario)
    everything = RadioConfig.model_validate(EVERYTHING)
    for tick in range(400):
        disturbed = 100 <= tick < 250
        state = stand(world, state)
        other = dataclasses.replace(other, channel=everything if disturbed else scenario.channel)
        other = stand(other_world, other)
        if not disturbed:
            assert other.radio.reception.tolist() == state.radio.reception.tolist()
    assert other.decoded < state.decoded
