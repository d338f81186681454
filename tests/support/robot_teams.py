"""Merged reports of real robots, made by hand."""

import math
from collections.abc import Sequence

import numpy as np

from fes.protocol.report import Report


def merged(estimates: Sequence[tuple[float, float]]) -> Report:
    """A report of robots in a chain: links 0-1, 1-2, ... with the `estimates` of both of their ends [m]."""
    n, links = len(estimates) + 1, len(estimates)
    unknown, none = np.full(links, math.nan), np.zeros(0, dtype=np.int64)
    numbers = np.array(estimates, dtype=np.float64).reshape(-1, 2)
    return Report(
        scenario="main",
        tick=0,
        ticks=0,
        dt=0.02,
        optimal_separation=math.nan,
        elapsed=0.0,
        ticks_per_s=math.nan,
        alive=np.ones(n, dtype=np.uint8),
        poses=np.zeros((n, 3)),
        a=np.arange(links),
        b=np.arange(links) + 1,
        separation=unknown,
        estimate_ab=numbers[:, 0],
        estimate_ba=numbers[:, 1],
        outage=unknown,
        sent=unknown,
        decoded=unknown,
        longest_gap=unknown,
        learnt_reception=unknown,
        learnt_level=unknown,
        learnt_exponent=unknown,
        beacons_sent=0,
        beacons_decoded=0,
        disagreement=0.0,
        estimate_error_max=math.nan,
        separation_error_max=math.nan,
        true_level=math.nan,
        true_exponent=math.nan,
        mean_estimate_error=math.nan,
        changed_at=0.0,
        tracking_time=math.nan,
        missed=none,
        late=none,
        disk_connected=True,
    )
