"""Each compiled function repeats its numpy twin to the bit, over all kinds of numbers and shapes."""

from collections.abc import Callable, Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from fes.arithmetic import angle, draws, exponential, logarithm, power, trigonometry
from fes.arithmetic.core import functions
from fes.arrays.types import Floats, Ints
from tests.support import bits, cores

COMPILED: Any = functions.load()
pytestmark = cores.needs(COMPILED)

MANY = 60_000
"""Numbers from a range; half as many come from all magnitudes."""

ONE: dict[str, tuple[Callable[[Floats], Any], list[tuple[float, float]]]] = {
    "exp": (exponential.exp, [(-760.0, 720.0), (-40.0, 3.0)]),
    "one_minus_exp": (exponential.one_minus_exp, [(0.0, 50.0), (0.0, 1.0)]),
    "log": (logarithm.log, [(0.0, 4.0), (0.98, 1.02)]),
    "log1p": (logarithm.log1p, [(-1.0, 4.0), (-0.01, 0.01)]),
    "log_sum_exp": (logarithm.log_sum_exp, [(-50.0, 50.0), (-800.0, 800.0)]),
    "sin_cos": (trigonometry.sin_cos, [(-10.0, 10.0), (-1e7, 1e7)]),
}
"""Functions of one number: the numpy twin, and two ranges where the function has structure."""

EXPONENTS = (
    0.0,
    0.5,
    1.0,
    2.0,
    2.5,
    3.0,
    4.0,
    7.0,
    15.5,
    16.0,
    -0.0,
    16.5,
    1.7,
    3.3,
    -0.5,
    -3.3,
    2.0000001,
    300.0,
    1e300,
)

SHAPES: dict[str, Callable[[Floats], Floats]] = {
    "no axis": lambda x: x[7],
    "an array without an axis": lambda x: np.asarray(x[7]),
    "one number": lambda x: x[7:8],
    "no number": lambda x: x[:0],
    "no row": lambda x: x[:0].reshape(0, 5),
    "every third number": lambda x: x[::3],
    "backward": lambda x: x[::-1],
    "a transposed table": lambda x: x[:600].reshape(20, 30).T,
    "columns of a table": lambda x: x[:600].reshape(20, 30)[:, 3:17:2],
    "broadcast": lambda x: np.broadcast_to(x[:50], (4, 50)),
    "three axes in the order of Fortran": lambda x: np.asfortranarray(x[:600].reshape(4, 5, 30)),
    "not a multiple of a register": lambda x: x[:61],
}


def numbers(low: float, high: float, seed: int = 0) -> Floats:
    """Special numbers, numbers of a range, and numbers of all magnitudes and both signs."""
    generator = np.random.default_rng(seed)
    wide = np.ldexp(generator.uniform(-1.0, 1.0, MANY // 2), generator.integers(-1074, 1025, MANY // 2))
    return np.concatenate([bits.SPECIAL, np.nextafter(bits.SPECIAL, 0.0), generator.uniform(low, high, MANY), wide])


@pytest.fixture(autouse=True)
def _quiet() -> Iterator[None]:
    """No warnings of numpy: the compiled functions have none."""
    with np.errstate(all="ignore"):
        yield


@pytest.mark.parametrize("name", ONE)
def test_a_function_of_one_number_repeats_numpy(name: str) -> None:
    twin, ranges = ONE[name]
    for seed, (low, high) in enumerate(ranges):
        x = numbers(low, high, seed)
        if name == "one_minus_exp":
            x = np.abs(x)
        assert not bits.differences(getattr(COMPILED, name)(x), twin(x))


def test_one_minus_exp_of_negative_numbers_is_not_defined_but_repeats_numpy_where_it_is_finite() -> None:
    x = np.random.default_rng(3).uniform(-700.0, 0.0, 10_000)
    assert not bits.differences(COMPILED.one_minus_exp(x), exponential.one_minus_exp(x))


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("name", ONE)
def test_any_shape_gives_the_shape_and_the_numbers_of_numpy(name: str, shape: str) -> None:
    x = SHAPES[shape](np.abs(numbers(0.0, 9.0)[400:1400]))
    ours, theirs = getattr(COMPILED, name)(x), ONE[name][0](x)
    assert not bits.differences(ours, theirs)
    for first, second in zip(np.atleast_1d(ours), np.atleast_1d(theirs), strict=True):
        assert type(first) is type(second)


def test_exp_and_rise_repeats_numpy() -> None:
    x, a = numbers(-760.0, 720.0), np.abs(numbers(0.0, 50.0, seed=1))
    assert not bits.differences(COMPILED.exp_and_rise(x, a), exponential.exp_and_rise(x, a))


def test_atan2_repeats_numpy_for_all_pairs_of_special_numbers() -> None:
    y, x = np.meshgrid(bits.SPECIAL, bits.SPECIAL)
    assert not bits.differences(COMPILED.atan2(y, x), angle.atan2(y, x))


@pytest.mark.parametrize("seed", range(3))
def test_atan2_repeats_numpy(seed: int) -> None:
    y, x = numbers(-10.0, 10.0, seed), numbers(-10.0, 10.0, seed + 10)
    np.random.default_rng(seed).shuffle(y)
    assert not bits.differences(COMPILED.atan2(y, x), angle.atan2(y, x))


@pytest.mark.parametrize("y", EXPONENTS)
def test_a_power_repeats_numpy(y: float) -> None:
    x = np.abs(numbers(0.0, 200.0))
    assert not bits.differences(COMPILED.power(x, y), power.power(x, y))


@pytest.mark.parametrize("n", range(18))
def test_a_product_repeats_numpy(n: int) -> None:
    x = numbers(-3.0, 3.0)
    assert not bits.differences(COMPILED.product(x, n), power.product(x, n))


def test_a_real_power_repeats_numpy() -> None:
    generator = np.random.default_rng(5)
    x = np.abs(numbers(0.0, 200.0))
    x = x[((x >= 2.0**-1022) & (x < np.inf)) | np.isnan(x)]
    for y in (
        generator.uniform(-9.0, 9.0, len(x)),
        generator.choice(bits.SPECIAL[np.isfinite(bits.SPECIAL)], len(x)),
    ):
        exponents = np.clip(y, -1e300, 1e300)
        assert not bits.differences(COMPILED.real_power(x, exponents), power.real_power(x, exponents))


def test_functions_of_two_numbers_broadcast_as_numpy_does() -> None:
    x, y = np.linspace(0.5, 9.0, 7)[:, None], np.linspace(-3.0, 3.0, 11)
    assert not bits.differences(COMPILED.real_power(x, y), power.real_power(x, y))
    assert not bits.differences(COMPILED.atan2(x, y), angle.atan2(x, y))
    assert not bits.differences(COMPILED.atan2(x[0, 0], y[3]), angle.atan2(x[0, 0], y[3]))
    assert not bits.differences(COMPILED.real_power(x[2], 1.7), power.real_power(x[2], 1.7))
    assert not bits.differences(COMPILED.real_power(x[:0], y), power.real_power(x[:0], y))


@pytest.mark.parametrize("shape", SHAPES)
def test_a_power_has_the_shape_of_its_argument(shape: str) -> None:
    x = SHAPES[shape](np.abs(numbers(0.0, 9.0)[400:1400]))
    for y in (0.0, 1.0, 2.5, 1.7):
        assert not bits.differences(COMPILED.power(x, y), power.power(x, y))


def test_the_library_wraps_angles_as_numpy_does() -> None:
    for seed, most in enumerate((50.0, 1e17)):
        angles = numbers(-most, most, seed)
        result = COMPILED._each("wrap", angles)
        # numpy's own functions are the definition here, not `geometry.wrap`
        assert not bits.differences(result, np.remainder(angles + np.pi, 2.0 * np.pi) - np.pi)


def test_a_uniform_number_is_that_of_philox_of_numpy() -> None:
    generator = np.random.default_rng(6)
    size = 100
    ends = [np.concatenate([generator.integers(0, 2**40, size), [0, 1, 2**62]]) for _ in range(2)]
    for seed in range(60):
        key = draws.key(seed, "channel")
        tick = int(generator.integers(0, 2**40)) if seed else 0
        for first in range(4 * (tick // 4), 4 * (tick // 4) + 8, 4):
            expected = np.array([philox(key, first // 4, *pair) for pair in zip(*ends, strict=True)])
            for offset in range(4):
                assert not bits.differences(
                    COMPILED.random_numbers(key, first + offset, *ends), expected[:, offset].copy()
                )


def philox(key: Any, counter: int, sender: int, receiver: int) -> Floats:
    """The four numbers in [0, 1) of a counter, by numpy's generator."""
    start = np.array([counter, sender, receiver, 0], dtype=np.uint64)
    words = np.random.Philox(key=key, counter=start).random_raw(4)
    return np.asarray((words >> np.uint64(11)) * 2.0**-53)


def test_numbers_for_many_ticks_are_those_of_philox_with_either_core(monkeypatch: pytest.MonkeyPatch) -> None:
    key, senders, receivers = draws.key(3, "bursts"), np.arange(40), np.arange(40)[::-1].copy()
    compiled = draws.uniform_ticks(key, 8, 16, senders, receivers)
    monkeypatch.setattr(functions, "load", lambda: None)
    assert not bits.differences(draws.uniform_ticks(key, 8, 16, senders, receivers), compiled)
    expected = [
        np.concatenate([philox(key, 2 + block, *pair) for block in range(4)])
        for pair in zip(senders.tolist(), receivers.tolist(), strict=True)
    ]
    assert not bits.differences(compiled, np.stack(expected, axis=1))


def test_the_results_that_the_self_test_expects_are_those_of_numpy() -> None:
    def uniform(key: Any, tick: int, senders: Ints, receivers: Ints) -> Floats:
        pairs = zip(senders.tolist(), receivers.tolist(), strict=True)
        return np.array(
            [philox(key.astype(np.uint64), tick // 4, int(low), int(high))[tick % 4] for low, high in pairs]
        )

    twins = {name: twin for name, (twin, _) in ONE.items()}
    others = {"atan2": angle.atan2, "power": power.power, "product": power.product, "real_power": power.real_power}
    assert functions.digest(SimpleNamespace(**twins, **others, random_numbers=uniform)) == functions.EXPECTED
