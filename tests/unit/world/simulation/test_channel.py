"""The radio: how often beacons decode, when contacts open, and what their draws depend on."""

import math

import numpy as np
import pytest

from fes.arithmetic import draws
from fes.arrays.types import Floats
from fes.model.sensing import CLOSED, DECODED, LOST
from tests.support import layouts
from world.config.scenario import Scenario, parse
from world.simulation import truth
from world.simulation.truth import State

Codes = dict[tuple[int, int], list[int]]
"""For each (receiver, sender) what became of its beacons, tick by tick; -1 out of range."""


def team(positions: list[tuple[float, float]], model: str = "rayleigh", seed: int = 4) -> Scenario:
    poses = [[x, y, 0.0] for x, y in positions]
    tables = {"schema": 1, "run": {"seed": seed}, "robots": {"poses": poses}, "channel": {"model": model}}
    return parse(tables, "test")


def listen(scenario: Scenario, speeds: list[Floats]) -> tuple[Codes, list[State]]:
    """The radio's verdicts at each tick, the robots moving along +x with `speeds` [n] of each tick."""
    world = truth.create(scenario)
    states = [truth.start(world)]
    for speed in speeds:
        states.append(truth.step(world, states[-1], np.column_stack([speed, np.zeros_like(speed)])))
    n = scenario.robots.number
    codes: Codes = {(i, j): [-1] * len(states) for i in range(n) for j in range(n) if i != j}
    for tick, state in enumerate(states):
        sensed = truth.observe(state)
        near = sensed.in_range
        for robot, peer, code in zip(
            near.ids[near.rows].tolist(), near.peers.tolist(), sensed.reception, strict=True
        ):
            codes[robot, peer][tick] = int(code)
    return codes, states


def still(n: int, ticks: int) -> list[Floats]:
    return [np.zeros(n)] * ticks


def test_a_beacon_decodes_with_the_probability_of_equation_3_independently_in_each_direction() -> None:
    ticks = 6000
    codes, _ = listen(team([(0, 0), (68, 0), (0, 140)]), still(3, ticks))
    separation = {(0, 1): 68.0, (0, 2): 140.0}
    deviation = []
    for (robot, peer), verdicts in codes.items():
        if (min(robot, peer), max(robot, peer)) not in separation:
            continue  # 155.6 m apart: out of range
        decoded = np.array(verdicts[2:]) == DECODED
        p = math.exp(-3e-7 * separation[min(robot, peer), max(robot, peer)] ** 3)
        sigma = math.sqrt(p * (1.0 - p) / len(decoded))
        assert decoded.mean() == pytest.approx(p, abs=4.0 * sigma)  # binomial
        deviation.append((decoded - p) / math.sqrt(p * (1.0 - p)))
    assert len(deviation) == 4
    limit = 4.0 / math.sqrt(ticks)  # 4 sigma of the correlation of independent numbers
    assert abs(np.triu(np.corrcoef(deviation), 1)).max() < limit  # between links and directions
    assert max(abs(np.corrcoef(d[:-1], d[1:])[0, 1]) for d in deviation) < limit  # between ticks


def test_robots_farther_apart_than_the_range_do_not_hear_each_other() -> None:
    codes, states = listen(team([(0, 0), (150.001, 0)], "perfect"), still(2, 5))
    assert codes[0, 1] == codes[1, 0] == [-1] * 6
    assert states[-1].sent == 0


def test_a_contact_opens_two_ticks_after_its_robots_came_in_range() -> None:
    # robot 1 comes closer by 1 m a tick (50 m/s), from 153.5 m: in range from tick 4 on
    codes, _ = listen(team([(0, 0), (153.5, 0)], "perfect"), [np.array([0.0, -50.0])] * 8)
    expected = [-1, -1, -1, -1, CLOSED, CLOSED, DECODED, DECODED, DECODED]
    assert codes[0, 1] == codes[1, 0] == expected


def test_a_contact_in_range_at_the_start_opens_at_tick_two() -> None:
    codes, _ = listen(team([(0, 0), (100, 0)], "perfect"), still(2, 3))
    assert codes[0, 1] == [CLOSED, CLOSED, DECODED, DECODED]


def test_a_lost_contact_reopens() -> None:
    there_and_back = [0.0] * 3 + [100.0] * 2 + [-100.0] * 5  # 2 m a tick from 147 m: 151 m at tick 5
    codes, _ = listen(team([(0, 0), (147, 0)], "perfect"), [np.array([0.0, v]) for v in there_and_back])
    expected = [CLOSED, CLOSED, DECODED, DECODED, DECODED, -1, CLOSED, CLOSED, DECODED, DECODED, DECODED]
    assert codes[0, 1] == codes[1, 0] == expected


def test_contacts_of_other_robots_stay_open_while_one_enters_and_leaves() -> None:
    there_and_back = ([100.0] * 4 + [-100.0] * 4) * 3
    speeds = [np.array([0.0, 0.0, v]) for v in there_and_back]
    codes, states = listen(team([(0, 0), (20, 0), (146, 0)], "perfect"), speeds)
    # 146, 148, 150, 152, 154, 152, 150, 148 m and so on: in range three ticks, out three, in five, out three
    opening = [CLOSED, CLOSED, DECODED, DECODED, DECODED, -1, -1, -1]
    assert codes[0, 2] == codes[2, 0] == [CLOSED, CLOSED, DECODED, -1, -1, -1, *opening, *opening, *opening[:3]]
    assert codes[0, 1] == codes[1, 0] == [CLOSED, CLOSED] + [DECODED] * 23
    heard = sum(code == DECODED for verdicts in codes.values() for code in verdicts)
    assert states[-1].sent == states[-1].decoded == heard


def test_a_beacon_is_judged_at_the_separation_at_which_it_was_sent() -> None:
    # 1 m apart at even ticks, 149 m at odd ones: beacons of even ticks decode (outage 3e-7) and are
    # reported at the odd tick after
    swing = [np.array([0.0, 7400.0 if tick % 2 == 0 else -7400.0]) for tick in range(2000)]
    codes, _ = listen(team([(0, 0), (1, 0)]), swing)
    odd, even = (np.array(codes[0, 1][start::2]) == DECODED for start in (3, 2))
    assert odd.all()
    p = math.exp(-3e-7 * 149.0**3)
    assert even.mean() == pytest.approx(p, abs=4.0 * math.sqrt(p * (1.0 - p) / len(even)))  # 4 sigma


def test_another_robot_changes_no_verdict_between_the_others() -> None:
    three = [(0.0, 0.0), (120.0, 0.0), (60.0, 90.0)]
    few, _ = listen(team(three), still(3, 300))
    many, _ = listen(team([*three, (60.0, 30.0)]), still(4, 300))
    assert LOST in few[0, 1]
    assert all(many[pair] == verdicts for pair, verdicts in few.items())


def test_another_robot_passing_by_changes_no_verdict_between_the_others() -> None:
    # its coming and going makes the radio draw anew in the middle of a block
    passing = [np.array([0.0, 0.0, 0.0, 150.0])] * 300
    few, _ = listen(team([(0, 0), (120, 0), (60, 90)]), still(3, 300))
    many, _ = listen(team([(0, 0), (120, 0), (60, 90), (-400, 30)]), passing)
    assert {-1, CLOSED, LOST, DECODED} <= set(many[0, 3])
    assert all(many[pair] == verdicts for pair, verdicts in few.items())


def test_another_controller_that_keeps_the_separations_changes_no_verdict() -> None:
    where = [(0.0, 0.0), (110.0, 0.0), (60.0, 90.0)]
    resting, _ = listen(team(where), still(3, 300))
    rng = np.random.default_rng(0)
    moving, _ = listen(team(where), [np.full(3, v) for v in rng.normal(0.0, 20.0, 300)])
    # separations differ by 1e-14: a draw falls between once in 1e13
    assert moving == resting


def test_a_nearer_pair_decodes_every_beacon_that_a_farther_one_with_the_same_draws_does() -> None:
    near, _ = listen(team([(0, 0), (70, 0)]), still(2, 1000))
    far, _ = listen(team([(0, 0), (130, 0)]), still(2, 1000))
    pairs = list(zip(near[0, 1], far[0, 1], strict=True))
    assert (LOST, DECODED) not in pairs
    assert {(LOST, LOST), (DECODED, LOST), (DECODED, DECODED)} <= set(pairs)


def test_a_verdict_depends_only_on_the_draw_of_its_own_tick_sender_and_receiver() -> None:
    codes, states = listen(team([(0, 0), (110, 0), (60, 90)], seed=4), still(3, 150))
    key = draws.key(4, "channel")
    for (receiver, sender), verdicts in codes.items():
        p = math.exp(-3e-7 * layouts.distance(states[0].poses, receiver, sender) ** 3)
        for tick in range(1, 149):  # what tick + 1 reports was sent at tick; open from tick 2
            counter = np.array([tick // 4, sender, receiver, 0], dtype=np.uint64)
            number = np.random.Generator(np.random.Philox(key=key, counter=counter)).random(4)[tick % 4]
            assert verdicts[tick + 1] == (DECODED if number < p else LOST)


def test_another_seed_gives_another_fading() -> None:
    verdicts = [listen(team([(0, 0), (110, 0)], seed=seed), still(2, 100))[0][0, 1] for seed in (4, 5)]
    assert verdicts[0] != verdicts[1]


def test_a_perfect_channel_decodes_every_beacon_in_range() -> None:
    codes, states = listen(team([(0, 0), (150, 0), (75, 100)], "perfect"), still(3, 50))
    assert all(verdicts == [CLOSED, CLOSED] + [DECODED] * 49 for verdicts in codes.values())
    assert states[-1].sent == states[-1].decoded == 6 * 49


def test_every_verdict_on_an_open_contact_is_counted_once() -> None:
    codes, states = listen(team([(0, 0), (110, 0), (60, 90)]), still(3, 200))
    flat = [code for verdicts in codes.values() for code in verdicts]
    assert states[-1].sent == flat.count(LOST) + flat.count(DECODED)
    assert states[-1].decoded == flat.count(DECODED)
    radio = states[-1].radio
    assert int(radio.sent.sum()) == states[-1].sent
    assert int(radio.decoded.sum()) == states[-1].decoded
