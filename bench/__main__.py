"""All benchmarks, in sequence: `python -m bench` from the root of the repository.

First the details: rates, times and sizes, one module after the other. Then the table of budgets (`bench.against`).
`--only` chooses rows, and `--short` is a quick look.
"""

import argparse
from pathlib import Path

from bench.against import choice, cores, environments
from bench.against.budgets import ROWS
from bench.against.plan import Plan
from bench.against.table import markdown
from bench.size import cost, growth
from bench.speed import compute, lockstep, recording, secure, startup


def details() -> None:
    """Print the figures beside the table."""
    compute.main()
    startup.main()
    lockstep.main()
    recording.main()
    secure.main()
    growth.main()
    cost.main()


def main() -> None:
    """Measure what the command line names, and print the table last."""
    parser = argparse.ArgumentParser(prog="python -m bench", description="Benchmarks and their budgets.")
    names = ", ".join(choice.words(ROWS))
    parser.add_argument("--only", metavar="A,B", help=f"rows, groups of rows, or the figures beside them: {names}")
    parser.add_argument("--rounds", type=int, default=5, help="rounds of each ratio (default 5; sweeps at most 3)")
    parser.add_argument("--seeds", type=int, default=1000, help="seeds of the whole sweep (default 1000)")
    parser.add_argument("--short", action="store_true", help="shorter runs, for a quick look")
    parser.add_argument("--cores", default="c,numpy", help=f"values of FES_CORE, of {', '.join(cores.CHOICES)}")
    parser.add_argument(
        "--cache", type=Path, default=environments.default_folder(), help="folder of the environments"
    )
    flags = parser.parse_args()
    if not set(flags.cores.split(",")) <= set(cores.CHOICES) or min(flags.rounds, flags.seeds) < 1:
        parser.error(f"--cores has words of {', '.join(cores.CHOICES)}; --rounds and --seeds are at least 1")
    try:
        rows, with_details = choice.chosen(ROWS, flags.only)
    except ValueError as error:
        parser.error(str(error))
    if with_details:
        details()
    if not rows:
        return
    used = [cores.probe(word) for word in flags.cores.split(",")]
    plan = Plan(flags.rounds, flags.seeds, flags.short, flags.cache.resolve(), used)
    lines = []
    for row in rows:
        print(f"measures {row.name}: {row.what}", flush=True)
        measured = choice.lines(row, plan)
        for line in measured:
            print(f"  {line.core}: {line.result}", flush=True)
        lines += measured
    print(f"\n{markdown(lines)}")


if __name__ == "__main__":
    main()
