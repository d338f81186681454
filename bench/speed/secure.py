"""Cost of TLS, access control and the audit: plain and secure runs, measured alternately.

The default is ten robots in ten processes. The arguments `configs/hundred.toml --agents-per-process 25` run a
hundred robots in four processes.
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
"""Flags of each kind of run; the audit has nothing to read if Zenoh's log is off."""


def measure(words: list[str], audit: bool) -> tuple[float, float]:
    """Ticks per second of a `fes run`, and CPU time per tick of all its processes [ms], start-up included."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    with tempfile.TemporaryDirectory() as folder:
        program = [sys.executable, "-c", "from console.cli import main; main()", "run"]
        output = subprocess.run(
            [*program, *words, "--headless", "--json", "--out", f"{folder}/run"],
            stdout=subprocess.PIPE,
            text=True,
            check=True,
            timeout=300,
            env=os.environ if audit else {**os.environ, "RUST_LOG": "off"},
        ).stdout
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    summary = json.loads(output)
    spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return float(summary["ticks_per_s"]), 1e3 * spent / summary["ticks"]


def main(words: Sequence[str] = ()) -> None:
    """Print rates, CPU times and their ratios to the plain run of the same round."""
    parser = argparse.ArgumentParser(prog="python -m bench.speed.secure", description=(__doc__ or "").splitlines()[0])
    parser.add_argument("scenario", nargs="?", type=Path, default=Path("configs/paper.toml"))
    parser.add_argument("--agents-per-process", type=int, default=1, metavar="N")
    parser.add_argument("--duration", type=float, default=20.0, metavar="S", help="simulated [s]")
    parser.add_argument("--rounds", type=int, default=5, metavar="N")
    flags = parser.parse_args(words)
    robots = load(flags.scenario).robots.number
    processes = -(-robots // flags.agents_per_process)
    print(f"secure: {flags.scenario.name}, {flags.duration:g} s, {robots} robots in {processes} processes")

    length = ["--duration", str(flags.duration), "--agents-per-process", str(flags.agents_per_process)]
    ratios: dict[str, list[list[float]]] = {kind: [] for kind in KINDS}
    for _ in range(flags.rounds):
        line, (rate, cpu) = [], (1.0, 1.0)
        for kind, security in KINDS.items():
            measured = measure([str(flags.scenario), *length, *security], audit="no audit" not in kind)
            if kind == "plain":
                rate, cpu = measured
            ratios[kind].append([measured[0] / rate, measured[1] / cpu])
            line.append(f"{kind} {measured[0]:4.0f} ticks/s {measured[1]:5.2f} ms CPU")
        print("  " + "    ".join(line), flush=True)
    for kind in list(KINDS)[1:]:
        rate_ratio, cpu_ratio = np.median(ratios[kind], axis=0)
        print(f"  median {kind}/plain: rate {rate_ratio:.2f}, CPU per tick {cpu_ratio:.2f}")


if __name__ == "__main__":
    main(sys.argv[1:])
