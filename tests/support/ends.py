"""Tables of docs/explanation/team.md: the best patches, and the ends of ten robots.

python -m tests.support.ends            # both tables; the runs of the second one take about two minutes
python -m tests.support.ends patches    # the first one only
"""

import sys
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from console.analysis import team_claims
from console.backends import inprocess
from fes.arrays.types import Floats
from fes.model.config import ObjectiveConfig
from fes.shapes import choice
from tests.support.configurations import START
from world.config import builtin
from world.config.scenario import load
from world.metrics import graphs
from world.metrics.team.coverage import covered_area
from world.metrics.team.progress import cutting_robots

SIZES = (*range(2, 21), 37, 50, 100)
SEEDS = range(1, 11)
RULES = {"two nearest": "paper", "relative neighborhood": "neighborhood"}
RADIUS = 50.0
"""r_min [m]."""

LINE, RING = 58.7, 65.4
"""Link lengths at which a line and a ring of ten robots are best [m]."""


class Patch(NamedTuple):
    """A row of the table of patches, by its columns."""

    n: int
    links: int
    neighbors: float
    hops: float
    hops_after_loss: float
    beta: float
    ratio: float
    """r_beta / r*."""
    at_optimum: float
    """F with links of r*."""
    at_best: float
    """F with links of r_beta."""
    area: float
    """Covered area at r_beta over n discs."""


class End(NamedTuple):
    """A row of the table of ends: ten robots at one place each."""

    team_index: float
    without_loss: float
    hectares: float
    links: int
    cutting: int
    delivery: float
    delivery_after_loss: float


def patch(n: int) -> Patch:
    """The patch of `n` robots."""
    shape, (best, longer) = choice.shape("lattice", n, 1), team_claims.spacings("lattice", n)
    return Patch(
        n,
        shape.links,
        shape.neighbors,
        shape.hops(0),
        shape.hops(1),
        shape.quality_weight(1, 1.0),
        longer / best,
        team_claims.index_of(best * shape.slots).value,
        team_claims.index_of(longer * shape.slots).value,
        covered_area(longer * shape.slots, RADIUS) / (n * np.pi * RADIUS**2),
    )


def end(places: Floats, links: int, cutting: int) -> End:
    """The end of robots at `places` [n, 2] [m]."""
    after, before = team_claims.index_of(places), team_claims.index_of(places, ObjectiveConfig(losses=0))
    area = covered_area(places, RADIUS) / 1e4
    return End(after.value, before.value, area, links, cutting, before.delivery, after.delivery)


def drawn(name: str, spacing: float) -> End:
    """The end of ten robots in a shape."""
    shape = choice.shape(name, 10, 1)
    first, second = np.nonzero(np.triu(shape.is_link))
    return end(spacing * shape.slots, shape.links, len(graphs.cut_rows(10, first, second)))


def shapes() -> Iterator[tuple[str, End]]:
    """The studied configurations, by name."""
    best, longer = team_claims.spacings("lattice", 10)
    yield "line at r*", drawn("line", best)
    yield f"line at {LINE} m", drawn("line", LINE)
    yield "ring at r*", drawn("ring", best)
    yield f"ring at {RING} m", drawn("ring", RING)
    yield "ladder 2 x 5 at r*", drawn("ladder", best)
    yield "patch at r*", drawn("lattice", best)
    yield "patch at r_beta", drawn("lattice", longer)


def runs(scenario: str, seeds: Sequence[int] = SEEDS) -> list[End]:
    """The ends of runs with different seeds."""
    ends = []
    for seed in seeds:
        *_, last = inprocess.ticks(load(builtin.file_of(scenario), {"run.seed": seed}))
        links = len(last.telemetry.links.undirected)
        ends.append(end(last.state.poses[:, :2], links, len(cutting_robots(last.state, last.telemetry))))
    return ends


def main() -> None:
    """Print the tables."""
    _print(Patch._fields, ([f"{value:.5g}" for value in patch(n)] for n in SIZES))
    if sys.argv[1:] == ["patches"]:
        return
    _print(["ten robots", *End._fields], _ends())


def _ends() -> Iterator[list[str]]:
    start = end(START, 0, 0)
    yield ["the paper's start", *(f"{value:.4g}" if value else "-" for value in start)]
    for rule, scenario in RULES.items():
        yield [f"{rule}, {len(SEEDS)} seeds", *_cells(runs(scenario))]
    for name, of_shape in shapes():
        yield [name, *_cells([of_shape])]
    yield ["marks and plans", *_cells(runs("team-paper-start", SEEDS[:1]))]


def _cells(ends: list[End]) -> list[str]:
    """Median of each column, and its range if it has one."""
    cells = []
    for column in np.array(ends, dtype=np.float64).T:
        low, high, median = column.min(), column.max(), np.median(column)
        cells.append(f"{median:.4g}" if high - low < 5e-4 else f"{median:.3g} [{low:.3g}, {high:.3g}]")
    return cells


def _print(heads: Sequence[str], rows: Iterator[list[str]] | Any) -> None:
    print("| " + " | ".join(heads) + " |")
    print("|" + "---|" * len(heads))
    for row in rows:
        print("| " + " | ".join(row) + " |", flush=True)
    print()


if __name__ == "__main__":
    main()
