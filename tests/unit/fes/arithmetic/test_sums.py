"""Sums in the order of their terms, against loops, math.fsum and fractions."""

import math
from fractions import Fraction

import numpy as np
import pytest

from fes.arithmetic import sums
from fes.arrays.types import Floats


def spread(*shape: int) -> Floats:
    """Numbers of very different sizes: their sum depends on the order."""
    generator = np.random.default_rng(16)
    return generator.normal(size=shape) * 10.0 ** generator.uniform(-8.0, 8.0, shape)


def in_order(values: Floats) -> float:
    """The sum by a loop."""
    result = float(values[0])
    for value in values[1:].tolist():
        result += value
    return result


@pytest.mark.parametrize("m", [1, 2, 7, 8, 9, 100, 1000, 100_003])
def test_a_total_is_that_of_a_loop(m: int) -> None:
    values = spread(m)
    assert sums.total(values) == in_order(values)
    assert sums.mean(values) == in_order(values) / m
    # m - 1 additions, each within half an ulp of a partial sum, which is at most the sum of magnitudes
    assert abs(sums.total(values) - math.fsum(values)) <= m * 2.0**-53 * math.fsum(np.abs(values))


def test_the_order_of_terms_decides() -> None:
    assert sums.total(np.array([1e16, 1.0, -1e16, 1.0])) == 1.0
    assert sums.total(np.array([1e16, -1e16, 1.0, 1.0])) == 2.0


def test_nothing_adds_up_to_zero_and_has_no_mean() -> None:
    nothing = np.zeros(0)
    assert sums.total(nothing) == 0.0
    assert math.isnan(sums.mean(nothing))
    assert sums.of_rows(np.zeros((3, 0))).tolist() == [0.0] * 3
    assert sums.of_columns(np.zeros((0, 1))).tolist() == [0.0]
    assert sums.of_rows(np.zeros((0, 3))).shape == (0,)


@pytest.mark.parametrize("n", [1, 2, 3, 50])
@pytest.mark.parametrize("m", [1, 7, 9, 64, 1000])
def test_each_row_and_column_adds_up_as_alone_in_any_layout(n: int, m: int) -> None:
    rows = spread(n, m)
    expected = [in_order(row) for row in rows]
    for layout in (
        rows,
        np.asfortranarray(rows),
        np.repeat(rows, 2, axis=1)[:, ::2],
        np.repeat(rows, 2, axis=0)[::2],
    ):
        assert sums.of_rows(layout).tolist() == expected
        assert sums.of_columns(layout.T).tolist() == expected


def test_a_matrix_product_of_integers_is_exact() -> None:
    first, second = np.random.default_rng(17).integers(-99, 99, (2, 5, 5))
    expected = [
        [sum(int(first[i, k]) * int(second[k, j]) for k in range(5)) for j in range(5)] for i in range(5)
    ]  # fmt: skip
    assert sums.product(first.astype(float), second.astype(float)).tolist() == expected


@pytest.mark.parametrize("shapes", [((2, 3), (3, 4)), ((1, 9), (9, 1)), ((7, 1), (1, 7)), ((2, 2, 5), (2, 5, 3))])
def test_a_matrix_product_is_a_loop_over_terms_and_close_to_the_exact_one(
    shapes: tuple[tuple[int, ...], ...],
) -> None:
    first, second = spread(*shapes[0]), spread(*shapes[1])
    result = sums.product(first, second)
    for where in np.ndindex(result.shape):
        *batch, i, j = where
        row, column = first[*batch, i], second[*batch, :, j]
        assert result[where] == in_order(row * column)
        terms = [Fraction(a) * Fraction(b) for a, b in zip(row.tolist(), column.tolist(), strict=True)]
        exact, size = sum(terms, Fraction(0)), sum(map(abs, terms), Fraction(0))
        assert abs(Fraction(float(result[where])) - exact) <= len(terms) * size / 2**53
