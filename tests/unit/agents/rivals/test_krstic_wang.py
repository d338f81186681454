"""Extremum seeking per link against scalar code, and its climb from counted beacons."""

import math

import numpy as np
import pytest

from agents.rivals.krstic_wang import KrsticWang, KrsticWangParameters
from fes.arrays.edges import no_edges
from fes.arrays.types import Floats
from fes.extension import Entry
from fes.extension.protocols import Formed
from tests.support.surroundings import DT, around, context, everyone, pair

AMPLITUDE, OMEGA, WASHOUT, LOW_PASS, GAIN, KAPPA = 5.0, 0.5, 0.1, 0.2, 10.0, 1.0
LAW = KrsticWang(
    KrsticWangParameters(
        dither_amplitude=AMPLITUDE,
        dither_frequency=OMEGA,
        washout_cutoff=WASHOUT,
        low_pass_cutoff=LOW_PASS,
        gain=GAIN,
        consensus_gain=KAPPA,
        initial_estimate=(85.0, 95.0),
    ),
    context(2),
)
NOTHING = Formed(None, np.zeros((2, 2)))


def preference(r: float) -> float:
    return (1.0 - math.exp(-((r / 50.0) ** 4))) * math.exp(-((r / 150.0) ** 4))


def begin() -> Floats:
    entry = Entry(0, np.array([True, True]), np.full(2, np.nan))
    return LAW.relink(LAW.start(), no_edges(np.arange(2)), everyone(2), entry)


def test_each_tick_is_that_of_the_scalar_law() -> None:
    random = np.random.default_rng(7)
    state = begin()
    estimate, baseline, slope = state[0, 0], preference(state[0, 0]), 0.0
    assert 85.0 <= estimate <= 95.0
    assert state[1, 0] == pytest.approx(baseline, rel=1e-12)
    for tick in range(1, 200):
        separation, decoded = float(random.uniform(60.0, 90.0)), random.random(2) < 0.7
        peer = float(random.uniform(60.0, 90.0))
        seen = around(pair(separation), tick, decoded, estimates=np.array([peer, np.nan]))
        state = LAW.seek(LAW.measure(state, seen, NOTHING), seen)

        sample = preference(separation) if decoded[0] else 0.0
        baseline += DT * WASHOUT * (sample - baseline)
        slope += DT * LOW_PASS * ((sample - baseline) * math.sin(OMEGA * DT * (tick - 1)) - slope)
        estimate += DT * (GAIN * slope + KAPPA * (peer - estimate))
        # roundings of 200 ticks
        assert state[:, 0] == pytest.approx([estimate, baseline, slope], rel=1e-11)


def test_the_links_are_driven_to_the_dithered_estimates() -> None:
    state = begin()
    desired = LAW.desired(state, 40, everyone(2))
    assert desired == pytest.approx(state[0] + AMPLITUDE * math.sin(OMEGA * 40 * DT), rel=1e-12)
    assert LAW.physical_period(KrsticWangParameters(dither_frequency=OMEGA)) == pytest.approx(4.0 * math.pi)


def test_the_estimates_of_a_link_climb_towards_the_optimum_from_beacons_alone() -> None:
    random = np.random.default_rng(3)
    state = begin()
    assert state[0].min() > 85.0
    for tick in range(1, 10_000):
        separation = float(LAW.desired(state, tick - 1, everyone(2)).mean())
        decoded = random.random(2) < math.exp(-3e-7 * separation**3)
        seen = around(pair(separation), tick, decoded, estimates=state[0][::-1].copy())
        state = LAW.seek(LAW.measure(state, seen, NOTHING), seen)
    # r* is 68.1 m, the start more than 17 m away; the spread of the end is a few meters
    assert abs(state[0].mean() - 68.1) < 8.0
    assert abs(state[0, 0] - state[0, 1]) < 2.0


def test_a_new_link_begins_with_the_mean_of_its_robot() -> None:
    state = np.array([[70.0, 80.0], [0.5, 0.5], [0.0, 0.0]])
    entry = Entry(50, np.array([False, False, True]), np.full(3, np.nan))
    three = everyone(3)
    old = three.select(three.robots == 0)
    grown = LAW.relink(state, old, three, entry)
    assert grown[0, :2].tolist() == [70.0, 80.0]
    assert ((grown[0, 2:] >= 85.0) & (grown[0, 2:] <= 95.0)).all()  # robots 1 and 2 had no link
    one = three.select((three.robots == 0) & (three.peers == 1))
    assert LAW.relink(state[:, :1], one, old, entry)[0].tolist() == [70.0, 70.0]
