"""Horner's scheme against the same steps in Python's floats."""

import numpy as np
import pytest

from fes.arithmetic import exact
from fes.arithmetic.polynomial import horner


@pytest.mark.parametrize("shape", [(), (1,), (1, 1), (2,), (3, 5), (0,)])
@pytest.mark.parametrize("count", [2, 3, 12])
def test_each_step_is_a_rounded_product_and_a_rounded_sum(shape: tuple[int, ...], count: int) -> None:
    generator = np.random.default_rng(20)
    coefficients, z = generator.normal(size=count), generator.normal(size=shape)
    result = np.asarray(horner(exact.constants(*coefficients.tolist()), np.asarray(z)))
    assert result.shape == shape
    for value, point in zip(result.ravel().tolist(), np.ravel(z).tolist(), strict=True):
        expected = coefficients[0] * point + coefficients[1]
        for coefficient in coefficients[2:]:
            expected = expected * point + coefficient
        assert value == expected
