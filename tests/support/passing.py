"""The study of safe separation: 1,000 runs of robots that pass each other, by kind.

    python -m tests.support.passing

It prints the table of docs/explanation/safe-separation.md. Runs that did not keep the filter's conditions at every
tick are counted apart. A kind runs as one crew of many teams, with the product's own world and `crew.step`.
"""

import argparse
import math
import sys
import time

from tests.support.passing_kinds import COUNTS, batches
from tests.support.passing_runs import Outcome, run

HEADS = ("kind", "runs", "least [m]", "broke a condition", "least of these [m]", "arrived", "last arrival [s]")
WITHOUT_GOALS = ("pursuit", "squeeze", "random pulls", "clocks off")
"""Kinds in which no robot arrives."""


def row(kind: str, outcomes: list[Outcome]) -> list[str]:
    """The cells of one kind."""
    kept, broken = ([o.least for o in outcomes if o.is_broken is is_broken] for is_broken in (False, True))
    times = [outcome.arrived for outcome in outcomes if math.isfinite(outcome.arrived)]
    arrived = ["-", "-"]
    if kind not in WITHOUT_GOALS:
        arrived = [f"{len(times)} of {len(outcomes)}", f"{max(times):.0f}" if times else "-"]
    return [kind, str(len(outcomes)), _least(kept), str(len(broken)), _least(broken), *arrived]


def _least(values: list[float]) -> str:
    return f"{min(values):.3f}" if values else "-"


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kind", choices=COUNTS, help="only this kind")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    print("|", " | ".join(HEADS), "|\n|" + "---|" * len(HEADS), flush=True)
    everything: list[Outcome] = []
    for kind in [options.kind] if options.kind else COUNTS:
        begun = time.monotonic()
        outcomes = [o for batch in batches({kind: COUNTS[kind]}, options.seed) for o in run(batch)]
        print("|", " | ".join(row(kind, outcomes)), "|", flush=True)
        print(f"{kind}: {time.monotonic() - begun:.0f} s", file=sys.stderr)
        everything += outcomes
    with_goals = [outcome for outcome in everything if outcome.kind not in WITHOUT_GOALS]
    print("|", " | ".join([*row("all", everything)[:5], *row("all", with_goals)[5:]]), "|")
    return 0


if __name__ == "__main__":
    sys.exit(main())
