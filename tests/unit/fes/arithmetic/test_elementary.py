"""All elementary functions: errors against mpmath, and the same bits in any array."""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from fes.arithmetic import elementary
from fes.arrays.types import Floats, read_only
from tests.support import accuracy
from tests.support.accuracy_ranges import TRIALS, Trial

POINTS = 1000
"""Per range; the long form is python -m tests.support.accuracy."""

FUNCTIONS: dict[str, tuple[Callable[..., Floats], list[tuple[float, float]]]] = {
    "exp": (elementary.exp, [(-750.0, 709.0)]),
    "one_minus_exp": (elementary.one_minus_exp, [(0.0, 45.0)]),
    "exp of exp_and_rise": (lambda x, a: elementary.exp_and_rise(x, a)[0], [(-5.0, 5.0), (0.0, 5.0)]),
    "rise of exp_and_rise": (lambda x, a: elementary.exp_and_rise(x, a)[1], [(-5.0, 5.0), (0.0, 5.0)]),
    "log": (elementary.log, [(-0.1, 3.0)]),
    "log1p": (elementary.log1p, [(-1.1, 3.0)]),
    "log_sum_exp": (elementary.log_sum_exp, [(-40.0, 40.0)]),
    "sin": (lambda x: elementary.sin_cos(x)[0], [(-2e6, 2e6)]),
    "cos": (lambda x: elementary.sin_cos(x)[1], [(-2e6, 2e6)]),
    "atan2": (elementary.atan2, [(-1.0, 1.0), (-1.0, 1.0)]),
    "cube": (lambda x: elementary.power(x, 3.0), [(0.0, 9.0)]),
    "power 2.5": (lambda x: elementary.power(x, 2.5), [(0.0, 9.0)]),
    "power -0.3": (lambda x: elementary.power(x, -0.3), [(0.0, 9.0)]),
    "real_power": (elementary.real_power, [(0.1, 9.0), (-9.0, 9.0)]),
}
"""Each function, with a range of each argument."""


def arguments(ranges: list[tuple[float, float]], count: int = 120) -> list[Floats]:
    generator = np.random.default_rng(15)
    return [generator.uniform(low, high, count) for low, high in ranges]


def layouts(values: list[Floats]) -> Iterator[tuple[list[Floats], Callable[[Floats], Floats]]]:
    """The same arguments in other arrays, and how to bring the results back in order."""
    n = len(values[0])
    yield [v.reshape(4, n // 4) for v in values], np.ravel
    yield [np.asfortranarray(v.reshape(4, n // 4)) for v in values], np.ravel
    yield [v[::-1] for v in values], lambda result: result[::-1]
    yield [np.repeat(v, 3)[1::3] for v in values], lambda result: result
    yield [np.concatenate([[0.5], v, [1.0, 2.0]])[1 : n + 1] for v in values], lambda result: result
    yield [np.frombuffer(b"-" + v.tobytes(), offset=1) for v in values], lambda result: result  # unaligned
    yield [read_only(v) for v in values], lambda result: result


@pytest.mark.parametrize("trial", TRIALS, ids=lambda trial: f"{trial.function}, {trial.range}")
def test_the_error_is_below_its_bound(trial: Trial) -> None:
    with np.errstate(over="raise", invalid="raise", divide="raise"):
        errors = accuracy.compare(trial, POINTS, [15])
    assert errors.worst < trial.bound, errors.where


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_result_is_the_same_in_any_array(name: str) -> None:
    function, ranges = FUNCTIONS[name]
    values = arguments(ranges)
    expected = function(*values)
    for others, back in layouts(values):
        assert back(function(*others)).tobytes() == expected.tobytes()


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_result_is_the_same_alone_and_beside_others(name: str) -> None:
    function, ranges = FUNCTIONS[name]
    values = arguments(ranges)
    expected = function(*values)
    for index, point in enumerate(zip(*values, strict=True)):
        for alone in (point, map(np.array, point), ([value] for value in point)):
            assert np.asarray(function(*map(np.asarray, alone))).tobytes() == expected[index].tobytes()
        assert np.float64(function(*point)).tobytes() == expected[index].tobytes()  # scalars of numpy
    assert function(*(value[:0] for value in values)).shape == (0,)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_nan_gives_nan_and_changes_no_other_result(name: str) -> None:
    function, ranges = FUNCTIONS[name]
    values = arguments(ranges)
    expected = function(*values)
    for value in values:
        value[7] = np.nan
    result = function(*values)
    assert np.isnan(result[7])
    assert np.delete(result, 7).tobytes() == np.delete(expected, 7).tobytes()


@pytest.mark.parametrize("name", FUNCTIONS)
def test_arguments_are_not_written(name: str) -> None:
    function, ranges = FUNCTIONS[name]
    values = arguments(ranges)
    before = [value.copy() for value in values]
    function(*values)
    assert all(np.array_equal(value, copy) for value, copy in zip(values, before, strict=True))


@pytest.mark.parametrize(
    "function", [elementary.exp, elementary.one_minus_exp, elementary.log, elementary.log1p, elementary.sin_cos]
)
def test_whole_numbers_count_as_the_same_floats(function: Callable[[Any], Any]) -> None:
    whole = np.array([1, 2, 3, 7])
    assert np.array_equal(function(whole), function(whole.astype(np.float64)))
    assert np.array_equal(elementary.real_power(whole, 2.5), elementary.real_power(whole.astype(np.float64), 2.5))
    assert np.array_equal(elementary.atan2(whole, whole[::-1]), elementary.atan2(1.0 * whole, 1.0 * whole[::-1]))
