"""Bursts of losses against the closed forms of a two-state Markov chain."""

import math
from typing import Any

import numpy as np
import pytest

from fes.arrays.types import Floats
from fes.errors import ScenarioError
from fes.model.sensing import DECODED, LOST
from world.config.radio import BurstConfig
from world.config.scenario import Scenario, parse
from world.simulation import bursts, truth
from world.simulation.bursts import BAD, GOOD, UNKNOWN
from world.simulation.truth import State

DT = 0.02
BURSTS = {"bad_share": 0.25, "mean_length": 0.16}  # 8 ticks: leaves with 1/8, enters with 1/24
MEMORY = 1.0 - 1.0 / 8.0 - 1.0 / 24.0
"""Autocorrelation of the state from one tick to the next."""


def chains(chains: int, ticks: int, **config: Any) -> Floats:
    """States of independent chains [ticks, chains]; numbers of numpy's own, not of `fes.arithmetic.draws`."""
    rng, law = np.random.default_rng(8), BurstConfig.model_validate({**BURSTS, **config})
    states = [np.full(chains, UNKNOWN, dtype=np.uint8)]
    for _ in range(ticks):
        states.append(bursts.step(states[-1], law, DT, rng.random(chains)))
    return np.array(states[1:], dtype=np.float64)


def scatter_of_share(share: float, samples: int, memory: float) -> float:
    """Standard deviation of the share of bad ones of `samples` in a row, correlated by `memory` to the lag."""
    return math.sqrt(share * (1.0 - share) / samples * (1.0 + memory) / (1.0 - memory))


def test_a_contact_is_bad_for_its_share_of_the_time_from_the_first_tick_on() -> None:
    states = chains(2000, 500)
    assert set(np.unique(states)) == {GOOD, BAD}
    assert states.mean() == pytest.approx(0.25, abs=4.0 * scatter_of_share(0.25, states.size, MEMORY))
    for tick in (0, 1, 10, 499):  # independent chains at one tick: binomial
        assert states[tick].mean() == pytest.approx(0.25, abs=4.0 * math.sqrt(0.25 * 0.75 / 2000))


@pytest.mark.parametrize(("length", "share"), [(0.02, 0.25), (0.16, 0.25), (0.5, 0.6)])
def test_a_stay_in_the_bad_state_has_its_mean_length(length: float, share: float) -> None:
    states = chains(500, 800, mean_length=length, bad_share=share)
    entered = (states[:-1] == GOOD) & (states[1:] == BAD)
    lengths = []
    for tick, chain in np.argwhere(entered[:400]).tolist():  # 400 ticks are left: no stay of 25 on average is cut
        stay = states[tick + 1 :, chain] == GOOD
        lengths.append(int(np.argmax(stay)) if stay.any() else len(stay))
    mean = length / DT
    deviation = math.sqrt(mean * (mean - 1.0)) + 1e-9  # of a geometric law
    assert len(lengths) > 1000
    assert np.mean(lengths) == pytest.approx(mean, abs=4.0 * deviation / math.sqrt(len(lengths)))


def test_the_state_is_forgotten_geometrically() -> None:
    states = chains(2000, 400) - 0.25
    for lag in (1, 2, 5, 12, 30):
        each = (states[lag:] * states[: len(states) - lag]).mean(axis=0) / (0.25 * 0.75)  # chains are independent
        assert abs(each.mean() - MEMORY**lag) < 4.0 * each.std() / math.sqrt(len(each))


def cluster(n: int, seed: int = 3, **channel: Any) -> Scenario:
    """n robots on a circle, all in range of one another."""
    around = np.arange(n) * 2.0 * math.pi / n
    poses = [[50.0 * math.cos(angle), 50.0 * math.sin(angle), 0.0] for angle in around.tolist()]
    return parse({"schema": 1, "run": {"seed": seed}, "robots": {"poses": poses}, "channel": channel}, "here")


def play(scenario: Scenario, ticks: int, velocity: Floats | None = None) -> list[State]:
    """The states of a run; robots stand still, or go along +x with `velocity` [n]."""
    world = truth.create(scenario)
    twists = np.zeros((scenario.robots.number, 2))
    if velocity is not None:
        twists[:, 0] = velocity
    states = [truth.start(world)]
    for _ in range(ticks):
        states.append(truth.step(world, states[-1], twists))
    return states


@pytest.mark.parametrize(("model", "loss"), [("perfect", 1.0), ("perfect", 0.6), ("rayleigh", 0.8)])
def test_the_overall_loss_is_that_of_channel_and_chain(model: str, loss: float) -> None:
    ticks = 1500
    state = play(cluster(12, model=model, bursts={**BURSTS, "loss": loss}), ticks)[-1]
    radio, sent = state.radio, 132 * (ticks - 1)
    assert int(radio.sent.sum()) == state.sent == sent
    where = state.poses[:, :2]
    separation = np.hypot(*(where[radio.edges.rows] - where[radio.edges.peers]).T)
    p = np.exp(-3e-7 * separation**3) if model == "rayleigh" else np.ones(132)
    kept = 1.0 - 0.25 * loss
    # the variance of the chain, and at most that of independent draws
    sigma = math.hypot(loss * scatter_of_share(0.25, sent, MEMORY), math.sqrt(0.25 / sent))
    assert state.decoded / sent == pytest.approx(kept * float(p.mean()), abs=4.0 * sigma)
    np.testing.assert_allclose(radio.probability, p * kept, rtol=1e-13)  # the average over the chain, not its state
    np.testing.assert_allclose(radio.outage_sum, (ticks - 1) * (1.0 - p * kept), rtol=1e-11)  # 1500 roundings


def test_beacons_of_a_perfect_channel_are_lost_in_the_bad_state_and_in_no_other() -> None:
    states = play(cluster(4, model="perfect", bursts=BURSTS), 300)
    for state in states[2:]:
        assert ((state.radio.reception == LOST) == (state.radio.burst == BAD)).all()
    assert {LOST, DECODED} <= set(states[-1].radio.reception.tolist())


def test_directions_and_pairs_burst_independently() -> None:
    states = play(cluster(4, model="perfect", bursts=BURSTS), 6000)
    bad = np.array([state.radio.burst for state in states[1:]], dtype=np.float64)
    assert bad.shape == (6000, 12)
    # the product of two independent chains is correlated by MEMORY^2 a tick
    limit = 4.0 * math.sqrt((1.0 + MEMORY**2) / (1.0 - MEMORY**2) / 6000)
    assert abs(np.triu(np.corrcoef(bad.T), 1)).max() < limit * 1.2  # the largest of 66


def verdicts(states: list[State], n: int) -> dict[tuple[int, int], list[tuple[int, int]]]:
    """Reception and burst of each pair of the first n robots, tick by tick."""
    by_pair: dict[tuple[int, int], list[tuple[int, int]]] = {}
    for state in states:
        radio = state.radio
        pairs = zip(radio.edges.rows.tolist(), radio.edges.peers.tolist(), strict=True)
        for pair, *verdict in zip(pairs, radio.reception.tolist(), radio.burst.tolist(), strict=True):
            if max(pair) < n:
                by_pair.setdefault(pair, []).append((verdict[0], verdict[1]))
    return by_pair


def test_another_robot_nearby_or_passing_changes_no_chain_of_other_pairs() -> None:
    def team(*more: list[float]) -> Scenario:
        poses = [[0.0, 0.0, 0.0], [120.0, 0.0, 0.0], [60.0, 90.0, 0.0], *more]
        return parse({"schema": 1, "robots": {"poses": poses}, "channel": {"bursts": BURSTS}}, "here")

    few = verdicts(play(team(), 300), 3)
    assert len(few) == 6
    assert few == verdicts(play(team([60.0, 30.0, 0.0]), 300), 3)
    passing = play(team([-400.0, 30.0, 0.0]), 300, np.array([0.0, 0.0, 0.0, 150.0]))
    assert {len(state.radio.edges) for state in passing} >= {6, 12}
    assert few == verdicts(passing, 3)


def test_bursts_that_lose_nothing_change_no_verdict_of_the_fading() -> None:
    plain, idle = play(cluster(5), 200), play(cluster(5, bursts={**BURSTS, "loss": 0.0}), 200)
    assert [s.radio.reception.tolist() for s in plain] == [s.radio.reception.tolist() for s in idle]


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"bad_share": 0.0, "mean_length": 1.0}, "channel.bursts.bad_share: must be greater than 0, got 0.0"),
        ({"bad_share": 1.0, "mean_length": 1.0}, "channel.bursts.bad_share: must be less than 1, got 1.0"),
        ({"bad_share": 0.5, "mean_length": -1.0}, "channel.bursts.mean_length: must be greater than 0, got -1.0"),
        ({"bad_share": 0.5}, "channel.bursts.mean_length: is required"),
        (
            {"bad_share": 0.5, "mean_length": 1.0, "loss": 1.5},
            "channel.bursts.loss: must be less than or equal to 1, got 1.5",
        ),
        (
            {"bad_share": 0.5, "mean_length": 0.01},
            "channel.bursts.mean_length must be at least run.dt, 0.02 s, got 0.01",
        ),
        (
            {"bad_share": 0.9, "mean_length": 0.1},
            "channel.bursts.mean_length must be at least run.dt x bad_share / (1 - bad_share), 0.18 s, got 0.1",
        ),
    ],
)
def test_an_impossible_chain_is_rejected_in_one_line(given: dict[str, float], message: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        cluster(2, bursts=given)
    assert str(caught.value) == f"here: {message}"
