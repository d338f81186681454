"""The panel of connectivity: components of the links and of the disk graph, and the robots that are absent."""

from functools import lru_cache

import numpy as np

from console.dashboard.canvas import Line
from console.terminal.formatting import styled
from fes.protocol.report import Report
from world.metrics import graphs

MAX_SPECTRUM = 250
"""Maximum number of robots for which the algebraic connectivity is computed; beyond, it would delay the display."""

_MOST = 40  # absent robots that are named


def connectivity(report: Report) -> list[Line]:
    """Connectivity of the links and of the disk graph of the robots present, and the robots that are not."""
    sizes, lambda_2 = _spectrum((report.alive == 1).tobytes(), report.a.tobytes(), report.b.tobytes())
    state = styled("connected", "green")
    if len(sizes) != 1:
        largest = ", ".join(map(str, sizes[:3])) + (", …" if len(sizes) > 3 else "")
        state = styled(f"{len(sizes):,} components ({largest})" if sizes else "no robot is alive", "yellow")
    algebraic = styled("" if lambda_2 is None else f"  λ₂ {lambda_2:.3g}")
    disk = styled("connected", "green") if report.disk_connected else styled("not connected", "yellow")
    graph = "heard       " if report.is_of_robots else "disk graph  "
    lines = [[styled("links       ", "dim"), state, algebraic], [styled(graph, "dim"), disk]]
    absent = np.flatnonzero(report.alive != 1).tolist()
    if absent:
        names = ", ".join(map(str, absent[:_MOST])) + (", …" if len(absent) > _MOST else "")
        lines.append([styled("not alive   ", "dim"), styled(names, "bold red")])
    return lines


@lru_cache(maxsize=8)
def _spectrum(present: bytes, a: bytes, b: bytes) -> tuple[list[int], float | None]:
    """Sizes of the components of the robots present, largest first, and lambda_2; None for less than two robots.

    Links of absent robots do not count. Cached, because links rarely change.
    """
    is_present = np.frombuffer(present, dtype=np.bool_)
    ends = np.frombuffer(a, dtype=np.int64), np.frombuffer(b, dtype=np.int64)
    known = (np.minimum(*ends) >= 0) & (np.maximum(*ends) < len(is_present))
    lower, higher = ends[0][known], ends[1][known]
    used = is_present[lower] & is_present[higher]
    row = np.cumsum(is_present) - 1
    n, lower, higher = int(np.count_nonzero(is_present)), row[lower[used]], row[higher[used]]
    sizes = np.unique(graphs.components(n, lower, higher), return_counts=True)[1] if n else np.zeros(0, dtype=int)
    lambda_2: float | None = 0.0  # exact where the graph is not connected
    if len(sizes) <= 1:
        lambda_2 = graphs.algebraic_connectivity(n, lower, higher) if 2 <= n <= MAX_SPECTRUM else None
    return sorted(sizes.tolist(), reverse=True), lambda_2
