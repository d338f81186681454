"""Rules of a configuration: they reject settings with which its plans cannot agree, or cannot keep the network."""

from fes.arrays import geometry
from fes.model import counts
from fes.model.config import FormationConfig
from fes.model.seeking import MeasuredConfig, SeekingConfig
from fes.shapes import routes
from fes.shapes.choice import shape
from fes.shapes.shape import TOLERANCE, Shape

MOST_ROBOTS = 200
"""Largest team that takes up a configuration: each robot knows the mark of every other, and plans take n^3 steps."""

PASSES, SPARE = 4, 10
"""A plan period must have at least PASSES (n/m + SPARE) ticks: a mark is relayed once in n/m ticks, and beacons are
lost."""


def check(formation: FormationConfig, seeking: SeekingConfig, dt: float, robots: int) -> None:
    """Raise ValueError in one line unless `robots` can take up the configuration with ticks of `dt` [s]."""
    if formation.configuration == "none":
        return
    if robots > MOST_ROBOTS:
        raise ValueError(f"formation.configuration is for at most {MOST_ROBOTS} robots, got {robots}")
    if isinstance(seeking, MeasuredConfig) and seeking.pooling == "none":
        raise ValueError(
            "formation.configuration needs a dither that all links share: seeking.pooling must be 'network', "
            "got 'none'"
        )
    marks = formation.marks_per_beacon
    least = PASSES * (robots / marks + SPARE)
    if counts.ticks(formation.plan_period, dt) < least:
        raise ValueError(
            f"formation.plan_period must be at least {PASSES} x (robots / marks_per_beacon + {SPARE}) ticks, "
            f"{least * dt:g} s, got {formation.plan_period:g}"
        )
    if formation.configuration == "offsets":
        _check_offsets(formation.offsets, robots)


def check_range(formation: FormationConfig, communication_range: float) -> None:
    """Raise ValueError in one line if a configuration counts on links that are out of range [m]."""
    if formation.configuration != "none" and formation.keep_range >= communication_range:
        raise ValueError(
            f"formation.keep_range must be below channel.communication_range, {communication_range:g} m, "
            f"got {formation.keep_range:g}"
        )


def outermost_speed(formation: FormationConfig, seeking: SeekingConfig, losses: int, robots: int) -> float:
    """Largest speed [m/s] at which a physical dither moves the outermost robot of a shape; 0 without either."""
    dither = getattr(seeking, "common_dither", None)
    if formation.configuration == "none" or dither is None:
        return 0.0
    amplitude, frequency = dither
    return float(amplitude * frequency * _of(formation, losses, robots).reach)


def _of(formation: FormationConfig, losses: int, robots: int) -> Shape:
    return shape(formation.configuration, robots, losses, tuple(formation.offsets))


def _check_offsets(offsets: list[tuple[float, float]], robots: int) -> None:
    """Raise ValueError in one line unless the first n offsets are one team, for each number n up to `robots`."""
    if len(offsets) < robots:
        raise ValueError(f"formation.offsets must have a place for each of {robots} robots, got {len(offsets)}")
    for n in range(2, len(offsets) + 1):
        first = shape("offsets", n, 0, tuple(offsets[:n]))
        nearest = float(routes.between(geometry.distances(first.slots)).min())
        if abs(nearest - 1.0) > TOLERANCE:
            raise ValueError(
                f"formation.offsets: the nearest two of the first {n} must be 1 link length apart, got {nearest:g}"
            )
        if not routes.reaches_all(first.is_link):
            raise ValueError(
                f"formation.offsets: the first {n} are not connected by links of up to {1.0 + TOLERANCE:g} times the "
                "shortest"
            )
