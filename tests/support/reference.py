"""Independent witnesses: the paper's formulas as plain scalar code, and scipy behind typed signatures.

Nothing here imports the code under test.
"""

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import integrate, linalg, optimize, sparse, stats

OPTIMUM_50 = 68.113761
"""r* [m] of the paper's channel at r_min = 50 (science.md, section 1)."""
OPTIMUM_100 = 105.384321
"""r* [m] of the paper's channel at r_min = 100; science.md prints ...322, 40 digits give ...32145."""

Rate = Callable[[float, list[float]], Sequence[float]]


def preference(r: complex, minimum: float, maximum: float, shape: float) -> complex:
    """S(r) of (16); complex, so that the derivative is the imaginary part of a complex step."""
    return complex((1.0 - np.exp(-((r / minimum) ** shape))) * np.exp(-((r / maximum) ** shape)))


def reception(r: complex, snr: float = 1e7, efficiency: float = 2.0, exponent: float = 3.0) -> complex:
    """1 - (3) with r0 = 1 m."""
    return complex(np.exp(-(2.0**efficiency - 1.0) / snr * r**exponent))


def paper_index(r: float, minimum: float = 50.0) -> float:
    """(33) with the paper's numbers: shape 4, r_x 150, SNR 1e7, delta 2, path loss 3."""
    spread = -math.expm1(-((r / minimum) ** 4))
    return spread * math.exp(-((r / 150.0) ** 4)) * math.exp(-3e-7 * r**3)


def complex_step(f: Callable[[complex], complex], argument: float) -> float:
    """f'(at) without subtraction, so to rounding error."""
    step = 1e-30
    return f(complex(argument, step)).imag / step


def flow(rate: Rate, state: Sequence[float], begin: float, end: float, rtol: float = 1e-11) -> NDArray[np.float64]:
    """The state at `end` of state' = rate(t, state), by an eighth-order method of variable step."""
    solution = integrate.solve_ivp(
        lambda t, x: rate(t, x.tolist()), (begin, end), list(state), "DOP853", rtol=rtol, atol=1e-12
    )
    assert solution.success, solution.message
    return np.array(solution.y[:, -1])


def exponential(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """The matrix exponential."""
    return np.array(linalg.expm(matrix))


def maximizer(f: Callable[[float], float], low: float, high: float) -> float:
    """Argument of the maximum of f in [low, high], by Brent's method without derivatives."""
    result = optimize.minimize_scalar(
        lambda x: -f(x), bounds=(low, high), method="bounded", options={"xatol": 1e-11 * high}
    )
    assert result.success
    return float(result.x)


def root(f: Callable[[float], float], low: float, high: float) -> float:
    """Zero of f in [low, high]."""
    return float(optimize.brentq(f, low, high, xtol=1e-13, rtol=1e-14))


def uniform_p_value(sample: NDArray[np.float64]) -> float:
    """p-value of the Kolmogorov-Smirnov test against the uniform distribution on [0, 1)."""
    return float(stats.kstest(sample, "uniform").pvalue)


def component_labels(n: int, pairs: Sequence[tuple[int, int]]) -> list[int]:
    """A label per node, equal within a connected component."""
    matrix = sparse.lil_matrix((n, n))
    for a, b in pairs:
        matrix[a, b] = 1
    return [int(label) for label in sparse.csgraph.connected_components(matrix, directed=False)[1]]
