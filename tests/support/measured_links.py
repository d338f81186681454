"""Measurements drawn from a known channel."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from console.fit.measurements import Packets, Powers
from fes.arrays.types import Floats

Probability = Callable[[Floats], Floats]


def rayleigh(separation: Floats) -> Floats:
    """Equation (3) with the paper's numbers, by hand: exp(-3e-7 r^3)."""
    probability: Floats = np.exp(-3e-7 * separation**3)
    return probability


def logistic(separation: Floats) -> Floats:
    """A midpoint of 90 m and a width of 12 m."""
    probability: Floats = 1.0 / (1.0 + np.exp((separation - 90.0) / 12.0))
    return probability


def packets(probability: Probability, seed: int, count: int = 500) -> Packets:
    """Packets over separations from 20 to 160 m."""
    rng = np.random.default_rng(seed)
    separation = rng.uniform(20.0, 160.0, count)
    return Packets(separation, rng.uniform(size=count) < probability(separation))


def powers(seed: int, threshold: float, decoded_only: bool, count: int = 500) -> Powers:
    """Rayleigh-faded power of -20 dBm at 1 m and exponent 3, over separations from 20 to 160 m."""
    rng = np.random.default_rng(seed)
    separation = rng.uniform(20.0, 160.0, count)
    rssi = -20.0 - 30.0 * np.log10(separation) + 10.0 * np.log10(rng.exponential(size=count))
    chosen = rssi >= threshold if decoded_only else np.ones(count, dtype=np.bool_)
    return Powers(separation[chosen], rssi[chosen], threshold)


def write(path: Path, measured: Packets | Powers) -> Path:
    """A file of these measurements."""
    name, values = ("decoded", measured.decoded) if isinstance(measured, Packets) else ("rssi", measured.rssi)
    rows = zip(measured.separation.tolist(), values.tolist(), strict=True)
    lines = [f"separation,{name}", *(f"{separation!r},{value!r}" for separation, value in rows)]
    path.write_text("\n".join(lines), encoding="utf-8")
    return path
