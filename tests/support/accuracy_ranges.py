"""The ranges over which the elementary functions are compared with mpmath, and the bounds of their errors."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

import mpmath
import numpy as np

from fes.arithmetic import elementary
from fes.arrays.types import Floats

Points: TypeAlias = Callable[[np.random.Generator, int], Floats]
"""Draws a number of arguments."""


@dataclass(frozen=True)
class Trial:
    """A function over a range of arguments."""

    function: str
    range: str
    ours: Callable[..., Floats]
    numpys: Callable[..., Floats]
    exact: Callable[..., Any]
    """The function of mpmath."""
    arguments: tuple[Points, ...]
    bound: float = 1.0
    """The error is below this [ulp]."""


def uniform(low: float, high: float) -> Points:
    """Numbers between two ends."""
    return lambda generator, n: generator.uniform(low, high, n)


def decades(low: float, high: float, signed: bool = False) -> Points:
    """Powers of ten whose exponents lie between two ends; half of them negative if `signed`."""
    return lambda generator, n: (
        10.0 ** generator.uniform(low, high, n) * (generator.choice([-1.0, 1.0], n) if signed else 1.0)
    )


def near_one(generator: np.random.Generator, n: int) -> Floats:
    """1 + d with |d| from 1e-16 to 0.01."""
    return 1.0 + decades(-16, -2, signed=True)(generator, n)


def near_quarters(generator: np.random.Generator, n: int) -> Floats:
    """Close to multiples of pi/2, where sin or cos is close to 0, up to 1e6."""
    quarters = np.rint(generator.uniform(-6e5, 6e5, n)) * (np.pi / 2)
    return quarters + decades(-20, -3, signed=True)(generator, n)


def slopes(generator: np.random.Generator, n: int) -> Floats:
    """Slopes of uniform angles from 0 to pi/2."""
    result: Floats = np.tan(generator.uniform(0.0, np.pi / 2, n))
    return result


def _sine(x: Floats) -> Floats:
    return elementary.sin_cos(x)[0]


def _cosine(x: Floats) -> Floats:
    return elementary.sin_cos(x)[1]


def _trials(function: str, ours: Any, numpys: Any, exact: Any, bound: float, ranges: dict[str, Any]) -> list[Trial]:
    return [
        Trial(function, text, ours, numpys, exact, points if isinstance(points, tuple) else (points,), bound)
        for text, points in ranges.items()
    ]


def _power(y: float, bound: float) -> list[Trial]:
    """A power by products: each rounds once, and a square doubles the error of what it squares."""
    return _trials(
        f"x^{y:g}", lambda x: elementary.power(x, y), lambda x: np.power(x, y), lambda x: mpmath.power(x, y), bound,
        {"0.001 to 1000": decades(-3, 3)},
    )  # fmt: skip


TURNS = {
    "-7 to 7": uniform(-7, 7),
    "-1000 to 1000": uniform(-1000, 1000),
    "-1e6 to 1e6": uniform(-1e6, 1e6),
}

ZEROS = {"near multiples of pi/2, to 1e6": near_quarters}
"""Here the difference of an angle and the multiple nearest to it has lost most of its digits."""

TRIALS: list[Trial] = [
    *_trials("exp(x)", elementary.exp, np.exp, mpmath.exp, 1.0, {
        "-40 to 3": uniform(-40, 3),
        "-700 to 709.7": uniform(-700, 709.7),
        "-745 to -700": uniform(-745, -700),
        "-0.001 to 0.001": uniform(-1e-3, 1e-3),
    }),
    *_trials("1 - exp(-a)", elementary.one_minus_exp, lambda a: -np.expm1(-a), lambda a: -mpmath.expm1(-a), 2.0, {
        "0 to 5": uniform(0, 5),
        "0.3 to 0.4": uniform(0.3, 0.4),
        "5 to 45": uniform(5, 45),
        "1e-307 to 1": decades(-307, 0),
    }),
    *_trials("log(x)", elementary.log, np.log, mpmath.log, 1.0, {
        "0 to 4": uniform(5e-324, 4),
        "0.7 to 1.42": uniform(0.7, 1.42),
        "1 ± 1e-16 to 1 ± 0.01": near_one,
        "1e-320 to 1e308": decades(-320, 308),
    }),
    *_trials("log(1 + x)", elementary.log1p, np.log1p, mpmath.log1p, 1.0, {
        "-0.999999 to 0": uniform(-0.999999, 0),
        "-0.99 to 3": uniform(-0.99, 3),
        "± 1e-18 to ± 0.1": decades(-18, -1, signed=True),
    }),
    *_trials("log(1 + exp(z))", elementary.log_sum_exp, lambda z: np.logaddexp(0.0, z),
             lambda z: mpmath.log1p(mpmath.exp(z)), 2.0, {
        "-700 to 0": uniform(-700, 0),
        "-40 to 40": uniform(-40, 40),
    }),
    *_trials("sin(x)", _sine, np.sin, mpmath.sin, 1.0, TURNS | {"1e-307 to 1": decades(-307, 0)}),
    *_trials("sin(x)", _sine, np.sin, mpmath.sin, 1.0, ZEROS),
    *_trials("cos(x)", _cosine, np.cos, mpmath.cos, 1.0, TURNS),
    *_trials("cos(x)", _cosine, np.cos, mpmath.cos, 1.0, ZEROS),
    *_trials("atan2(y, x)", elementary.atan2, np.arctan2, mpmath.atan2, 1.0, {
        "-1 to 1 both": (uniform(-1, 1), uniform(-1, 1)),
        "± 1e-150 to ± 1e150 both": (decades(-150, 150, signed=True), decades(-150, 150, signed=True)),
        "± 1e-320 to ± 1e-300 both": (decades(-320, -300, signed=True), decades(-320, -300, signed=True)),
        "x = 1, all slopes alike": (slopes, uniform(1, 1)),
    }),
    *_trials("x^y", elementary.real_power, np.power, mpmath.power, 1.0, {
        "x 1e-9 to 1e5, y 0.5 to 8": (decades(-9, 5), uniform(0.5, 8)),
        "x 1e-9 to 1e5, y -20 to 20": (decades(-9, 5), uniform(-20, 20)),
        "x 0.7 to 1.42, y 0.5 to 8": (uniform(0.7, 1.42), uniform(0.5, 8)),
        "x = 10, y -323 to 308": (uniform(10, 10), uniform(-323, 308)),
    }),
    *_power(2.5, 2.0), *_power(3.0, 2.0), *_power(4.0, 3.0), *_power(16.0, 15.0),
]  # fmt: skip
