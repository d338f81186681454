"""Cost of the elementary functions in numpy: microseconds per call, and ratios to numpy's own functions.

Each function and numpy's own are called in turn, in one run; the least of many times counts. Prints a Markdown table.
"""

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from fes.arithmetic import elementary
from fes.arrays.types import Floats

SIZES = (1, 3, 15, 150, 1500)
"""Numbers of values per call."""

ROUNDS, CALLS = 40, 50

FUNCTIONS: dict[str, tuple[Callable[..., Any], Callable[..., Any], list[tuple[float, float]]]] = {
    "exp": (elementary.exp, np.exp, [(-40.0, 3.0)]),
    "one_minus_exp": (elementary.one_minus_exp, lambda a: -np.expm1(-a), [(0.0, 5.0)]),
    "exp_and_rise": (elementary.exp_and_rise, lambda x, a: (np.exp(x), -np.expm1(-a)), [(-40.0, 3.0), (0.0, 5.0)]),
    "log": (elementary.log, np.log, [(0.01, 4.0)]),
    "log1p": (elementary.log1p, np.log1p, [(-0.9, 3.0)]),
    "log_sum_exp": (elementary.log_sum_exp, lambda z: np.logaddexp(0.0, z), [(-40.0, 40.0)]),
    "sin_cos": (elementary.sin_cos, lambda x: (np.sin(x), np.cos(x)), [(-1000.0, 1000.0)]),
    "atan2": (elementary.atan2, np.arctan2, [(-1.0, 1.0), (-1.0, 1.0)]),
    "power, 4": (lambda x: elementary.power(x, 4.0), lambda x: np.power(x, 4.0), [(0.1, 9.0)]),
    "power, 2.5": (lambda x: elementary.power(x, 2.5), lambda x: np.power(x, 2.5), [(0.1, 9.0)]),
    "power, 3.3": (lambda x: elementary.power(x, 3.3), lambda x: np.power(x, 3.3), [(0.1, 9.0)]),
}
"""Each function, numpy's own, and the ranges of the arguments."""


def cost(function: Callable[..., Any], values: list[Floats]) -> float:
    """Time of a call [s]."""
    begun = time.perf_counter()
    for _ in range(CALLS):
        function(*values)
    return (time.perf_counter() - begun) / CALLS


def main() -> None:
    """Print the table."""
    print("| function | " + " | ".join(f"n = {n:,}" for n in SIZES) + " |")
    print("|---" * (len(SIZES) + 1) + "|")
    generator = np.random.default_rng(1)
    for name, (ours, numpys, ranges) in FUNCTIONS.items():
        cells = []
        for n in SIZES:
            values = [generator.uniform(low, high, n) for low, high in ranges]
            pairs = [(cost(ours, values), cost(numpys, values)) for _ in range(ROUNDS)]
            own, other = (min(times) for times in zip(*pairs, strict=True))
            cells.append(f"{own * 1e6:.1f} µs, {own / other:.1f}×")
        print(f"| `{name}` | " + " | ".join(cells) + " |")


if __name__ == "__main__":
    main()
