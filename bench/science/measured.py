"""Robots that count beacons, over seeds: the table of docs/explanation/counting-beacons.md. It takes some minutes."""

import argparse
import math
import os
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from console.backends import stacked
from world.config.scenario import load

CONFIGS = Path(__file__).parents[2] / "configs"

SHADOWING = {"channel.shadowing": {"deviation": 8.0, "decorrelation_distance": 20.0}, "run.duration": 180.0}
ORACLE = {"seeking.index": "oracle", "seeking.dither_amplitude": 0.2, "seeking.dither_frequency": 100.0}
SAMPLED = ORACLE | {
    "seeking.index": "sampled",
    "seeking.index_transform": "none",
    "seeking.index_gain": 44460.0,
    "run.duration": 300.0,
}
PRINTED = {"seeking.law": "paper"}

PARTS = 4
"""Number of array programs into which the runs of a row are stacked."""

COLUMNS = (
    "scenario",
    "time to 1 m, median / max [s]",
    "bias [m]",
    "rmse [m]",
    "separation rmse [m]",
    "largest disagreement [m]",
    "mean J",
    "links always connected",
)


@dataclass(frozen=True)
class Row:
    """One line of the table."""

    title: str
    scenario: str = "measured.toml"
    changes: dict[str, Any] = field(default_factory=dict)
    segment: int = 0
    """Segment of the run: 0 from the start, 1 after the first change."""


ROWS = [
    Row("measured"),
    Row("coverage, r_min 100", "measured-coverage.toml"),
    Row("after the SNR halved", "measured-jump.toml", segment=1),
    Row("logistic reception", changes={"channel.model": "logistic"}),
    Row("clocks up to 50 ms off", changes={"run.clock_skew": 0.05}),
    Row("(18) fed with samples, k = 1", changes=SAMPLED | PRINTED | {"seeking.index_gain": 1.0}),
    Row("(18) fed with samples, k = 44460", changes=SAMPLED | PRINTED),
    Row("the same, its sign corrected", changes=SAMPLED),
    Row("8 dB shadowing: oracle", changes=SHADOWING | ORACLE),
    Row("8 dB shadowing: pooled", changes=SHADOWING),
    Row("8 dB shadowing: each link alone", changes=SHADOWING | {"seeking.pooling": "none"}),
]


def outcomes(row: Row, seeds: Sequence[int]) -> list[dict[str, Any]]:
    """Tracking of the runs of these seeds in the row's segment."""
    scenarios = [load(CONFIGS / row.scenario, {**row.changes, "run.seed": int(seed)}) for seed in seeds]
    summaries = stacked.run(scenarios, row.title)
    return [
        {**summary["tracking"][row.segment], "connected": summary["links_connected_always"]} for summary in summaries
    ]


def line(row: Row, rows: list[dict[str, Any]]) -> str:
    """One row of the table, as Markdown."""

    def column(name: str) -> "np.ndarray[Any, np.dtype[np.float64]]":
        return np.array([math.nan if outcome[name] is None else outcome[name] for outcome in rows], dtype=np.float64)

    def rms(name: str) -> str:
        values = column(name)
        return f"{math.sqrt(float(np.mean(values**2))):.3f}" if np.isfinite(values).all() else "-"

    times = np.where(np.isnan(column("time_to_1m")), math.inf, column("time_to_1m"))
    bias, index = column("bias"), column("index")
    error = 1.0 / math.sqrt(max(1, len(rows) - 1))
    reached = int(np.isfinite(times).sum())
    cells = (
        row.title,
        f"{np.median(times):.1f} / {times.max():.1f}" if reached == len(rows) else f"{reached} of {len(rows)}",
        f"{bias.mean():+.3f} ± {bias.std() * error:.3f}",
        rms("rmse"),
        rms("separation_rmse"),
        f"{column('disagreement_max').max():.3f}",
        f"{index.mean():.4f} ± {index.std() * error:.4f}",
        f"{sum(outcome['connected'] for outcome in rows)} of {len(rows)}",
    )
    return "| " + " | ".join(cells) + " |"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--only", default="", help="rows whose title contains this")
    flags = parser.parse_args()
    print("| " + " | ".join(COLUMNS) + " |\n" + "|---" * len(COLUMNS) + "|")
    indices = {}
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        for row in ROWS:
            if flags.only in row.title:
                parts = pool.map(partial(outcomes, row), np.array_split(np.arange(flags.seeds), PARTS))
                rows = [outcome for part in parts for outcome in part]
                print(line(row, rows), flush=True)
                indices[row.title] = np.array([outcome["index"] for outcome in rows], dtype=np.float64)
    titles = [title for title in indices if "shadowing" in title]
    for compared in titles[:-1]:
        difference = indices[titles[-1]] - indices[compared]
        error = difference.std() / math.sqrt(max(1, len(difference) - 1))
        advantage = f"{difference.mean():+.4f} ± {error:.4f}"
        print(f"mean J, {titles[-1]}, minus that of '{compared}' on the same seeds: {advantage}")


if __name__ == "__main__":
    main()
