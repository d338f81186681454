"""What TLS, access control and the audit cost a tick: plain and secure runs in turn, `python -m bench.secure`.

Ten robots in ten processes, or what is named: `configs/hundred.toml --agents-per-process 25` are a hundred in four.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from world.config.scenario import load

KINDS: dict[str, list[str]] = {"plain": [], "secure": ["--secure"], "secure, no audit": ["--secure"]}
"""What is run; without its log Zenoh spares the world the audit."""


def measure(words: list[str], audit: bool) -> tuple[float, float]:
    """Ticks per second, and CPU time of all processes together for a tick [ms], start-up included, of a `fes run`."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    with tempfile.TemporaryDirectory() as folder:
        program = [sys.executable, "-c", "from console.cli import main; main()", "run"]
        said = subprocess.run(
            [*program, *words, "--headless", "--json", "--out", f"{folder}/run"],
            stdout=subprocess.PIPE,
            text=True,
            check=True,
            timeout=300,
            env=os.environ if audit else {**os.environ, "RUST_LOG": "off"},
        ).stdout
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    found = json.loads(said)
    spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return float(found["ticks_per_s"]), 1e3 * spent / found["ticks"]


def main(words: Sequence[str] = ()) -> None:
    """Print rates, CPU and their ratios to the plain run of the same round."""
    parser = argparse.ArgumentParser(prog="python -m bench.secure", description=(__doc__ or "").splitlines()[0])
    parser.add_argument("scenario", nargs="?", type=Path, default=Path("configs/paper.toml"))
    parser.add_argument("--agents-per-process", type=int, default=1, metavar="N")
    parser.add_argument("--duration", type=float, default=20.0, metavar="S", help="simulated [s]")
    parser.add_argument("--rounds", type=int, default=5, metavar="N")
    asked = parser.parse_args(words)
    robots = load(asked.scenario).robots.number
    processes = -(-robots // asked.agents_per_process)
    print(f"secure: {asked.scenario.name}, {asked.duration:g} s, robots: {robots}, their processes: {processes}")

    length = ["--duration", str(asked.duration), "--agents-per-process", str(asked.agents_per_process)]
    ratios: dict[str, list[list[float]]] = {kind: [] for kind in KINDS}
    for _ in range(asked.rounds):
        line, (rate, cpu) = [], (1.0, 1.0)
        for kind, flags in KINDS.items():
            found = measure([str(asked.scenario), *length, *flags], audit="no audit" not in kind)
            if kind == "plain":
                rate, cpu = found
            ratios[kind].append([found[0] / rate, found[1] / cpu])
            line.append(f"{kind} {found[0]:4.0f} ticks/s {found[1]:5.2f} ms CPU")
        print("  " + "    ".join(line), flush=True)
    for kind in list(KINDS)[1:]:
        faster, dearer = np.median(ratios[kind], axis=0)
        print(f"  median {kind}/plain: rate {faster:.2f}, CPU a tick {dearer:.2f}")


if __name__ == "__main__":
    main(sys.argv[1:])
