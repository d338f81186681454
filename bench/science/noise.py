"""Noisy, slow and late fixes, and bodies that slip and lag: the table of docs/explanation/noise.md, over seeds.

It takes about ten minutes. Bias and rms errors are of the time from 60 s on; `±` is the standard error over seeds.
"""

import argparse
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from console.backends import stacked
from fes.arrays.types import Floats
from world.config.scenario import load
from world.metrics import summary
from world.metrics.collector import MetricsCollector

CONFIGS = Path(__file__).parents[2] / "configs"

SETTLED = 60.0
"""Errors are averaged from this time on [s], as in the table `tracking` of a summary."""

DEGREE = math.pi / 180.0
SLIP = {"robots.slip": 0.05}
NO_FILTER = {"localization.filter": "none"}
LIMITS = {"formation.linear_limit": 5.0, "formation.angular_limit": 3.0}

COLUMNS = (
    "sensors and bodies",
    "filter",
    "time to 1 m, median / max [s]",
    "bias [m]",
    "rmse [m]",
    "separation rmse [m]",
    "omega rms [rad/s]",
    "links always connected",
)


def fixes(noise: float, heading: float, rate: float | None = None, **others: float) -> dict[str, Any]:
    """The settings of bodies that slip, and of fixes with this noise [m], also of the heading [degrees], and rate."""
    given = {"pose_noise": noise, "heading_noise": heading * DEGREE, **others}
    rated = {} if rate is None else {"pose_rate": rate}
    return SLIP | {f"sensing.{name}": value for name, value in (given | rated).items() if value}


LAG = {"robots.actuator_lag": 0.2}
GPS = fixes(1.0, 5.0, 5.0, pose_drift=0.5) | LIMITS
RTK = fixes(0.03, 1.0, 10.0) | LIMITS | {"formation.linear_limit": 2.0}


@dataclass(frozen=True)
class Row:
    """One line of the table."""

    title: str
    changes: dict[str, Any] = field(default_factory=dict)
    untold: dict[str, Any] = field(default_factory=dict)
    """Changes of the world that the robots' data sheets do not state."""
    many: bool = False
    """True if a difference of a few centimeters matters: the row has three times as many seeds."""

    @property
    def is_unfiltered(self) -> bool:
        """True if robots take each fix for their pose."""
        return self.changes.get("localization.filter") == "none"


ROWS = [
    Row("exact", many=True),
    Row("1 m", {"sensing.pose_noise": 1.0} | NO_FILTER, many=True),
    Row("1 m, 5°", fixes(1.0, 5.0), many=True),
    Row("0.3 m, 1°", fixes(0.3, 1.0)),
    Row("0.1 m, 1°", fixes(0.1, 1.0)),
    Row("1 m, 5°, drift 1 m in 30 s", fixes(1.0, 5.0, pose_drift=1.0)),
    Row("1 m, 5°, 5 fixes/s", fixes(1.0, 5.0, 5.0)),
    Row("1 m, 5°, 1 fix/s", fixes(1.0, 5.0, 1.0)),
    Row("no noise, 1 fix/s", fixes(0.0, 0.0, 1.0) | NO_FILTER),
    Row("no noise, 1 fix/s", fixes(0.0, 0.0, 1.0)),
    Row("0.03 m, 1°, 0.1 s old", fixes(0.03, 1.0, pose_latency=0.1) | NO_FILTER),
    Row("0.03 m, 1°, 0.1 s old", fixes(0.03, 1.0, pose_latency=0.1)),
    Row("1 m, 5°, lag 0.2 s told", fixes(1.0, 5.0) | LAG),
    Row("1 m, 5°, 10 fixes/s, lag 0.5 s not told", fixes(1.0, 5.0, 10.0), {"robots.actuator_lag": 0.5}),
    Row("1 m, 5°, at most 2 m/s", fixes(1.0, 5.0) | {"formation.linear_limit": 2.0}),
    Row("1 m, 5°, at most 5 m/s", fixes(1.0, 5.0) | {"formation.linear_limit": 5.0}),
    Row("GPS: 1 m, 5°, 5 fixes/s, drift 0.5 m, at most 5 m/s and 3 rad/s", GPS | NO_FILTER),
    Row("GPS: the same", GPS),
    Row("GPS, lag 0.2 s not told", GPS | NO_FILTER, LAG),
    Row("GPS, lag 0.2 s not told", GPS, LAG),
    Row("RTK: 0.03 m, 1°, 10 fixes/s, at most 2 m/s and 3 rad/s", RTK),
    Row("RTK, lag 0.2 s not told", RTK, LAG),
    Row("1 m, r_min 100", fixes(1.0, 0.0) | {"scenario": "measured-coverage.toml"}),
]


class Outcome(NamedTuple):
    """The end of one run: its table `tracking`, and what noise disturbs beside the estimate."""

    tracking: dict[str, Any]
    turning: float
    """Mean square of all angular velocities, settled [rad^2/s^2]."""
    connected: bool
    exponent: float
    """Path-loss exponent that the robots have fitted, settled [1]."""


def outcomes(
    changes: dict[str, Any], seeds: Sequence[int], duration: float = 180.0, untold: dict[str, Any] | None = None
) -> list[Outcome]:
    """Runs of `measured` with these changes, side by side; the robots do not know those of `untold`."""
    settings = {"run.duration": duration} | changes
    path = CONFIGS / settings.pop("scenario", "measured.toml")
    told = [load(path, settings | {"run.seed": int(seed)}) for seed in seeds]
    scenarios = [load(path, settings | (untold or {}) | {"run.seed": int(seed)}) for seed in seeds]
    metrics = [MetricsCollector(scenario) for scenario in scenarios]
    squares, exponents, count = np.zeros(len(scenarios)), np.zeros(len(scenarios)), 0
    settled = SETTLED / scenarios[0].run.dt
    for number, together in enumerate(stacked.ticks(scenarios, told)):
        for collector, tick in zip(metrics, together, strict=True):
            collector.add(tick.state, tick.twists, tick.telemetry)
        if number >= settled:
            squares += [np.mean(tick.twists[:, 1] ** 2) for tick in together]
            exponents += [np.mean(tick.telemetry.learnt[1]) for tick in together]
            count += 1
    ends = [summary.summarize(collector, "noise", "inprocess", 0.0) for collector in metrics]
    return [
        Outcome(end["tracking"][0], square / max(count, 1), end["links_connected_always"], exponent / max(count, 1))
        for end, square, exponent in zip(ends, squares.tolist(), exponents.tolist(), strict=True)
    ]


def column(rows: Sequence[Outcome], name: str) -> Floats:
    """One number of each run's tracking; NaN where a run has none."""
    values = [outcome.tracking[name] for outcome in rows]
    return np.array([math.nan if value is None else value for value in values], dtype=np.float64)


def rms(values: Floats) -> float:
    """Root of the mean square."""
    return math.sqrt(float(np.mean(values**2)))


def standard_error(values: Floats) -> float:
    """Standard error of the mean."""
    return float(values.std()) / math.sqrt(max(1, len(values) - 1))


def line(row: Row, rows: Sequence[Outcome]) -> str:
    """One row of the table, as Markdown."""
    times = column(rows, "time_to_1m")
    times, bias = np.where(np.isnan(times), math.inf, times), column(rows, "bias")
    cells = (
        row.title,
        "no" if row.is_unfiltered else "yes",
        f"{np.median(times):.1f} / {times.max():.1f}",
        f"{bias.mean():+.3f} ± {standard_error(bias):.3f}",
        f"{rms(column(rows, 'rmse')):.3f}",
        f"{rms(column(rows, 'separation_rmse')):.3f}",
        f"{math.sqrt(np.mean([outcome.turning for outcome in rows])):.1f}",
        f"{sum(outcome.connected for outcome in rows)} of {len(rows)}",
    )
    return "| " + " | ".join(cells) + " |"


def main() -> None:
    """Print the table; below it, each bias minus that of exact poses on the same seeds."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=8, help="of a row; three rows have three times as many")
    parser.add_argument("--duration", type=float, default=180.0, help="of each run [s]")
    parser.add_argument("--only", nargs="*", default=[], help="rows whose title contains one of these")
    flags = parser.parse_args()
    print("| " + " | ".join(COLUMNS) + " |\n" + "|---" * len(COLUMNS) + "|", flush=True)
    exact, biases = np.zeros(0), list[tuple[str, Floats]]()
    for row in ROWS:
        if flags.only and not any(part in row.title for part in flags.only):
            continue
        rows = outcomes(row.changes, range(3 * flags.seeds if row.many else flags.seeds), flags.duration, row.untold)
        print(line(row, rows), flush=True)
        if row.many:
            print(line(row, rows[: flags.seeds]), flush=True)
        exact = column(rows, "bias") if row.title == "exact" else exact
        biases.append((row.title + (", no filter" if row.is_unfiltered else ""), column(rows, "bias")))
    for title, bias in biases:
        if len(exact) and title != "exact":
            excess = bias - exact[: len(bias)]
            print(f"{title}: bias minus that of exact poses {excess.mean():+.3f} ± {standard_error(excess):.3f}")


if __name__ == "__main__":
    main()
