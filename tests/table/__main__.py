"""Run the team on its table, alone on the machine: `python -m tests.table [SEED...]`, 70 s for each seed.

It takes most of two processors in real time, so no other test may run beside it. Each claim is a line, and the last
line counts them. Exit code 0 if all hold.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

DURATION = 60.0
"""Time for which the robots may move [s]."""

LONGEST = 300.0
"""Longest time of a run [s]; it detects hangs only."""


def claims(seed: str, folder: Path) -> list[tuple[bool, str]]:
    """What one run shows: True for each claim that holds, and the claim with its figures."""
    out = folder / f"seed-{seed}"
    words = ["fes", "team", "run", "tabletop", "--body", "mujoco", "--seed", seed, "--duration", f"{DURATION:g}"]
    program = [str(Path(sys.executable).with_name(words[0])), *words[1:], "--out", str(out), "--json"]
    done = subprocess.run(program, capture_output=True, text=True, timeout=LONGEST, check=False)
    if done.returncode != 0:
        return [(False, f"seed {seed}: the run ends with {done.returncode}: {done.stderr.strip()[-300:]}")]
    result = json.loads(done.stdout)
    times = {name: result[name] if result[name] is not None else float("inf") for name in TIMES}
    rms = result["separation_error_rms"] if result["separation_error_rms"] is not None else float("inf")
    replay = [program[0], "replay", str(out), "--all"]
    again = subprocess.run(replay, capture_output=True, text=True, timeout=LONGEST, check=False)
    same = [line for line in again.stdout.splitlines() if "the same to the bit" in line]
    return [
        (times["estimate_time"] <= 20.0, f"mean estimate within 1 m from {times['estimate_time']:.1f} s on (20)"),
        (times["separation_time"] <= 60.0, f"separations within 1 m from {times['separation_time']:.1f} s on (60)"),
        (rms <= 0.5, f"separations off by {rms:.3f} m rms at the end (0.5)"),
        (again.returncode == 0 and len(same) == 10, f"{len(same)} of 10 robots' logs executed again to the bit"),
    ]


TIMES = ("estimate_time", "separation_time")


def main() -> int:
    """Run each seed; returns the exit code."""
    held = []
    with tempfile.TemporaryDirectory() as folder:
        for seed in sys.argv[1:] or ["1"]:
            for holds, claim in claims(seed, Path(folder)):
                print(f"{'passed' if holds else 'FAILED'}: seed {seed}: {claim}", flush=True)
                held.append(holds)
    print(f"{sum(held)} passed, {len(held) - sum(held)} failed", flush=True)
    return 0 if all(held) else 1


if __name__ == "__main__":
    sys.exit(main())
