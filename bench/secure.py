"""What TLS, access control and the audit cost a tick: plain and secure runs in turn, ten robots in ten processes."""

import json
import os
import resource
import subprocess
import sys
import tempfile

import numpy as np

ROUNDS = 5
DURATION = 20.0
KINDS: dict[str, list[str]] = {"plain": [], "secure": ["--secure"], "secure, no audit": ["--secure"]}
"""What is run; without its log Zenoh spares the world the audit."""


def measure(words: list[str], audit: bool) -> tuple[float, float]:
    """Ticks per second, and CPU time of all processes together for a tick [ms], start-up included."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    with tempfile.TemporaryDirectory() as folder:
        program = [sys.executable, "-c", "from console.cli import main; main()", "run", "configs/paper.toml"]
        said = subprocess.run(
            [*program, "--headless", "--json", "--duration", str(DURATION), "--out", f"{folder}/run", *words],
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


def main() -> None:
    """Print rates, CPU and their ratios to the plain run of the same round."""
    ratios: dict[str, list[list[float]]] = {kind: [] for kind in KINDS}
    print(f"secure: paper.toml, {DURATION:g} s, ten robots in ten processes")
    for _ in range(ROUNDS):
        line, (rate, cpu) = [], (1.0, 1.0)
        for kind, words in KINDS.items():
            found = measure(words, audit="no audit" not in kind)
            if kind == "plain":
                rate, cpu = found
            ratios[kind].append([found[0] / rate, found[1] / cpu])
            line.append(f"{kind} {found[0]:4.0f} ticks/s {found[1]:5.2f} ms CPU")
        print("  " + "    ".join(line), flush=True)
    for kind in list(KINDS)[1:]:
        faster, dearer = np.median(ratios[kind], axis=0)
        print(f"  median {kind}/plain: rate {faster:.2f}, CPU a tick {dearer:.2f}")


if __name__ == "__main__":
    main()
