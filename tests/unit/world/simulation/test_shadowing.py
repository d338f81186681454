"""Shadowing against its law: normal, of unit variance, with Gudmundson's correlation, the same from either end."""

import math
from collections.abc import Sequence

import numpy as np
import pytest

from fes.arrays.types import Floats
from tests.support import laws
from tests.support import reference as witness
from world.config.radio import RadioConfig, ShadowingConfig
from world.simulation import channel, neighbor_list, shadowing
from world.simulation.channel import RadioInput

UNIT = ShadowingConfig(deviation=1.0)  # 20 m
SEEDS = 400
CLONES = 20
"""Copies of a layout in each seed, so far apart that nothing connects them."""

Link = tuple[tuple[float, float], tuple[float, float]]


def samples(links: Sequence[Link], config: ShadowingConfig = UNIT) -> Floats:
    """g of each link, given by its ends, in many seeds and places [seeds, clones, links]."""
    ends = np.array(links)  # [links, 2, 2]
    away = 5000.0 * np.arange(CLONES)
    spread = np.stack([away, -0.7 * away], axis=1)  # [clones, 2]
    where = (spread[:, None, None, :] + ends).reshape(-1, 2)
    poses = np.column_stack([where, np.zeros(len(where))])
    a = np.arange(0, len(where), 2)
    apart = np.hypot(*(where[a] - where[a + 1]).T)
    drawn = [shadowing.gain(shadowing.modes(seed), config, poses, a, a + 1, apart) for seed in range(SEEDS)]
    return np.array(drawn).reshape(SEEDS, CLONES, len(links))


def assert_mean(values: Floats, expected: float) -> None:
    """The mean of values [seeds, clones] is as expected, to 4 sigma of the seeds' means."""
    each = values.mean(axis=1)
    assert abs(each.mean() - expected) < 4.0 * each.std() / math.sqrt(len(each))


def test_the_wave_vectors_are_bivariate_cauchy() -> None:
    vectors = np.concatenate([shadowing.modes(seed).vectors for seed in range(20)], axis=1)
    # z/|u|, with z normal in the plane and u normal: numpy's draws against ours, at one in a thousand
    rng = np.random.default_rng(2)
    drawn = rng.normal(size=(2, 200_000)) / abs(rng.normal(size=200_000))
    ranks = np.searchsorted(np.sort(np.hypot(*drawn)), np.hypot(*vectors)) / 200_000
    assert witness.uniform_p_value(ranks) > 1e-3
    assert witness.uniform_p_value(np.arctan2(vectors[1], vectors[0]) / (2.0 * math.pi) + 0.5) > 1e-3


def test_the_gain_is_the_sum_of_its_waves_written_out() -> None:
    waves, a, b = shadowing.modes(5), (31.0, -8.0), (55.0, 14.0)
    k = [complex(x, y) / 20.0 for x, y in waves.vectors.T.tolist()]
    q = [*k[1:], k[0]]

    def f(p: complex, other: complex) -> float:
        angles = zip(k, q, waves.phase.tolist(), strict=True)
        return sum(math.cos((u.conjugate() * p + v.conjugate() * other).real + phi) for u, v, phi in angles)

    apart = math.hypot(a[0] - b[0], a[1] - b[1])
    summed = math.sqrt(2.0 / shadowing.MODES) * (f(complex(*a), complex(*b)) + f(complex(*b), complex(*a)))
    expected = summed / math.sqrt(2.0 * (1.0 + math.exp(-2.0 * apart / 20.0)))
    poses = np.array([[*a, 0.3], [*b, -2.0]])
    result = shadowing.gain(waves, UNIT, poses, np.array([0]), np.array([1]), np.array([apart]))
    # angles of up to 1e4 rad are rounded to 1e-12, and 256 of them add up as their root
    assert float(result[0]) == pytest.approx(expected, abs=1e-11)


def test_the_gain_has_mean_zero_and_unit_variance_at_any_separation() -> None:
    apart = (0.0, 1.0, 10.0, 40.0, 150.0)
    drawn = samples([((0.0, 0.0), (r, 0.0)) for r in apart])
    for link in range(len(apart)):
        assert_mean(drawn[:, :, link], 0.0)
        assert_mean(drawn[:, :, link] ** 2, 1.0)


def test_the_gain_is_normal() -> None:
    poses = np.array([[0.0, 0.0, 0.0], [40.0, 0.0, 0.0]])
    ends, apart = (np.array([0]), np.array([1])), np.array([40.0])
    drawn = [float(shadowing.gain(shadowing.modes(seed), UNIT, poses, *ends, apart)[0]) for seed in range(3000)]
    cumulative = np.array([0.5 * (1.0 + math.erf(g / math.sqrt(2.0))) for g in drawn])
    assert witness.uniform_p_value(cumulative) > 1e-3  # Kolmogorov-Smirnov, at one in a thousand


def test_the_correlation_is_gudmundsons_when_one_end_or_both_move() -> None:
    still = ((0.0, 0.0), (140.0, 0.0))  # so long that exp(-r/d0) between its ends is 1e-3
    moved = [
        (((3.0, 4.0), (140.0, 0.0)), 5.0),
        (((0.0, 20.0), (140.0, 0.0)), 20.0),
        (((0.0, 0.0), (140.0, -20.0)), 20.0),
        (((0.0, 0.0), (170.0, 40.0)), 50.0),
        (((0.0, 10.0), (132.0, 6.0)), 20.0),
        (((12.0, 16.0), (140.0, 30.0)), 50.0),
    ]
    drawn = samples([still, *(link for link, _ in moved)])
    for index, (_, walked) in enumerate(moved, start=1):
        assert_mean(drawn[:, :, 0] * drawn[:, :, index], math.exp(-walked / 20.0))


def test_the_correlation_of_short_links_is_that_of_a_field_made_reciprocal() -> None:
    def rho(meters: float) -> float:
        return math.exp(-meters / 20.0)

    drawn = samples([((0.0, 0.0), (8.0, 0.0)), ((0.0, 0.0), (14.0, 0.0))])
    # E[(f(a,b) + f(b,a)) (f(a,c) + f(c,a))] = 2 rho(bc) + 2 rho(ab) rho(ac), by hand from E[f(a,b) f(c,d)]
    expected = (rho(6.0) + rho(8.0) * rho(14.0)) / math.sqrt((1.0 + rho(16.0)) * (1.0 + rho(28.0)))
    assert_mean(drawn[:, :, 0] * drawn[:, :, 1], expected)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_gains_over_the_places_of_one_seed_are_distributed_as_over_seeds(seed: int) -> None:
    rng, n = np.random.default_rng(seed), 4000
    poses = np.zeros((3 * n, 3))  # links of 200 m, one end of which then goes 20 m
    poses[:n, :2] = rng.uniform(-1e6, 1e6, (n, 2))
    poses[n : 2 * n, :2], poses[2 * n :, :2] = poses[:n, :2] + (200.0, 0.0), poses[:n, :2] + (200.0, 20.0)
    a = np.arange(n)
    apart = np.full(n, 200.0)
    waves = shadowing.modes(seed)
    first, second = (shadowing.gain(waves, UNIT, poses, a, a + far, apart) for far in (n, 2 * n))
    # over places cov = sum of cos(k d)/K, of variance (1 - exp(-2 d/d0))/(2 K), beside that of n samples
    sampling = 2.0 / n
    assert first.mean() == pytest.approx(0.0, abs=4.0 * math.sqrt(sampling))
    assert (first**2).mean() == pytest.approx(1.0, abs=4.0 * math.sqrt(sampling))
    waves_of_one_seed = (1.0 - math.exp(-2.0)) / (2.0 * shadowing.MODES)
    expected = pytest.approx(math.exp(-1.0), abs=4.0 * math.sqrt(sampling + waves_of_one_seed))
    assert (first * second).mean() == expected


def test_the_correlation_at_the_decorrelation_distance_is_1_over_e() -> None:
    far = ShadowingConfig(deviation=1.0, decorrelation_distance=60.0)
    drawn = samples([((0.0, 0.0), (400.0, 0.0)), ((0.0, 60.0), (400.0, 0.0))], far)
    assert_mean(drawn[:, :, 0] * drawn[:, :, 1], math.exp(-1.0))


def test_links_far_away_are_independent() -> None:
    drawn = samples([((0.0, 0.0), (60.0, 0.0)), ((0.0, 900.0), (60.0, 900.0)), ((0.0, 0.0), (60.0, 900.0))])
    for first, second in ((0, 1), (0, 2), (1, 2)):
        assert_mean(drawn[:, :, first] * drawn[:, :, second], 0.0)


def test_the_gain_in_db_is_the_deviation_times_a_field_of_the_seed() -> None:
    link = [((0.0, 0.0), (60.0, 0.0))]
    eight = samples(link, ShadowingConfig(deviation=8.0))
    np.testing.assert_allclose(eight, 8.0 * samples(link), rtol=1e-14)
    assert_mean(eight[:, :, 0] ** 2, 64.0)


def scattered(n: int) -> Floats:
    rng = np.random.default_rng(3)
    return np.column_stack([rng.uniform(-300.0, 300.0, (n, 2)), np.zeros(n)])


def probabilities(poses: Floats, config: RadioConfig, seed: int = 6) -> dict[tuple[int, int], float]:
    """The true reception probability of each (receiver, sender)."""
    near = neighbor_list.measure(np.arange(len(poses)), poses, config.communication_range, None)
    robots = RadioInput(0, poses, np.ones(len(poses), dtype=np.bool_), near)
    result = channel.reception_probability(channel.medium(seed, laws.world()), config, robots, near)
    return dict(
        zip(zip(near.edges.rows.tolist(), near.edges.peers.tolist(), strict=True), result.tolist(), strict=True)
    )


SHADED = RadioConfig(shadowing=ShadowingConfig(deviation=8.0))


def test_the_gain_is_the_same_to_the_bit_from_either_end() -> None:
    poses = scattered(100)
    result = probabilities(poses, SHADED)
    assert len(result) > 500
    assert all(result[sender, receiver] == p for (receiver, sender), p in result.items())
    a, b = np.triu_indices(100, 1)
    apart = np.hypot(*(poses[a, :2] - poses[b, :2]).T)
    waves = shadowing.modes(6)
    forth, back = (shadowing.gain(waves, UNIT, poses, *ends, apart) for ends in ((a, b), (b, a)))
    assert forth.tobytes() == back.tobytes()


@pytest.mark.parametrize("others", [1, 7, 97])
def test_another_robot_changes_no_digit_between_the_others(others: int) -> None:
    few, many = probabilities(scattered(100)[:3], SHADED), probabilities(scattered(100)[: 3 + others], SHADED)
    assert few
    assert all(many[pair] == p for pair, p in few.items())


def test_a_robot_that_returns_to_a_place_has_the_same_shadowing() -> None:
    first, second = scattered(6), scattered(6) + np.array([37.0, -12.0, 1.0])
    assert probabilities(first, SHADED) == probabilities(first, SHADED)
    assert probabilities(first, SHADED) != probabilities(second, SHADED)
    assert probabilities(first, SHADED, seed=7) != probabilities(first, SHADED)


def test_a_gain_multiplies_the_snr_of_equation_3() -> None:
    poses = scattered(40)
    result, gains = probabilities(poses, SHADED), 0
    for (i, j), p in result.items():
        r = math.hypot(*(poses[i, :2] - poses[j, :2]).tolist())
        gain = shadowing.gain(
            shadowing.modes(6), SHADED.shadowing or UNIT, poses, np.array([i]), np.array([j]), np.array([r])
        )
        outage = 3.0 / (1e7 * 10.0 ** (float(gain[0]) / 10.0)) * r**3
        assert p == pytest.approx(math.exp(-outage), rel=1e-12 * (1.0 + outage))  # roundings, times the exponent
        gains += abs(float(gain[0])) > 8.0
    assert gains > 20


def test_reception_averaged_over_shadows_is_the_integral_of_equation_3() -> None:
    r, deviation = 80.0, 6.0
    nodes, weights = np.polynomial.hermite_e.hermegauss(80)
    expected = float(weights @ np.exp(-3e-7 * r**3 * 10.0 ** (-deviation * nodes / 10.0)) / weights.sum())
    assert abs(expected - math.exp(-3e-7 * r**3)) > 0.02  # or shadowing would not show
    away = 5000.0 * np.arange(CLONES)
    poses = np.zeros((2 * CLONES, 3))
    poses[::2, 0], poses[1::2, 0] = away, away + r
    config = RadioConfig(shadowing=ShadowingConfig(deviation=deviation))
    drawn = [list(probabilities(poses, config, seed).values()) for seed in range(SEEDS)]
    assert_mean(np.array(drawn), expected)


def test_a_perfect_channel_has_no_shadows_and_no_deviation_no_effect() -> None:
    perfect = RadioConfig(model="perfect", shadowing=ShadowingConfig(deviation=8.0))
    assert set(probabilities(scattered(20), perfect).values()) == {1.0}
    flat = RadioConfig(shadowing=ShadowingConfig(deviation=0.0))
    assert probabilities(scattered(20), flat) == probabilities(scattered(20), RadioConfig())


def test_shadows_move_the_midpoint_of_a_logistic_channel() -> None:
    poses = scattered(30)
    config = RadioConfig(model="logistic", shadowing=ShadowingConfig(deviation=8.0))
    plain, shaded = probabilities(poses, SHADED), probabilities(poses, config)
    for (i, j), p in plain.items():  # the effective separation read off (3), put into the logistic function
        if 1e-6 < p < 1.0 - 1e-6:  # where it can be read to 1e-10
            effective = (-math.log(p) / 3e-7) ** (1.0 / 3.0)
            assert shaded[i, j] == pytest.approx(1.0 / (1.0 + math.exp((effective - 100.0) / 12.0)), rel=1e-7)


def test_an_extreme_channel_stays_finite() -> None:
    wild = RadioConfig(path_loss_exponent=0.01, shadowing=ShadowingConfig(deviation=50.0))
    together = np.zeros((4, 3))
    result = list(probabilities(np.concatenate([together, scattered(30)]), wild).values())
    assert np.isfinite(result).all()
    assert 0.0 <= min(result) <= max(result) <= 1.0
