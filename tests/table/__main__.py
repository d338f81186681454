"""Run the team on its table, alone on the machine: `python -m tests.table [SEED...]`, 70 s for each seed.

It takes most of two processors in real time, so no other test may run beside it. Each claim is a line, and the last
line counts them. Exit code 0 if all hold. A run in which the machine does not keep up with
real time shows nothing, and is repeated.
"""

import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

from console.team.table_command import was_busy

DURATION = 60.0
"""Time for which the robots may move [s]."""

NUMBERS = ("estimate_time", "separation_time", "separation_error_rms")

SEVERAL, OF_SEVERAL, OF_FEW = 3, 0.5, 1.0
"""From so many seeds on, the separations must be within 0.5 m, rms over the seeds. One run varies more: the errors
of 48 simulated seeds have an rms of 0.28 m after 60 s, and the worst is 0.66 m."""

TRIES = 3
"""Runs of a seed until one is in real time: others on this machine may take its processors."""

SKIPPED = 77
"""Exit code if no run was in real time."""

LONGEST = 300.0
"""Longest time of a run [s]; it detects hangs only."""


class Outcome(NamedTuple):
    """One run: its claims, with their figures and True for each that holds, and its last error."""

    claims: list[tuple[bool, str]]
    rms: float
    """Error of the separations at the end [m]."""


def outcome(seed: str, out: Path) -> Outcome | None:
    """Run one seed, with `out` as its run directory; None if the machine was too busy for real time."""
    words = ["fes", "team", "run", "tabletop", "--body", "mujoco", "--seed", seed, "--duration", f"{DURATION:g}"]
    program = [str(Path(sys.executable).with_name(words[0])), *words[1:], "--out", str(out), "--json"]
    done = subprocess.run(program, capture_output=True, text=True, timeout=LONGEST, check=False)
    if done.returncode != 0:
        return Outcome([(False, f"the run ends with {done.returncode}: {done.stderr.strip()[-300:]}")], math.inf)
    result = json.loads(done.stdout)
    if was_busy(result):
        return None
    estimate, separation, rms = (math.inf if result[name] is None else result[name] for name in NUMBERS)
    replay = [program[0], "replay", str(out), "--all"]
    again = subprocess.run(replay, capture_output=True, text=True, timeout=LONGEST, check=False)
    same = [line for line in again.stdout.splitlines() if "the same to the bit" in line]
    claims = [
        (estimate <= 20.0, f"mean estimate within 1 m from {estimate:.1f} s on (20)"),
        (separation <= 60.0, f"separations within 1 m from {separation:.1f} s on (60)"),
        (again.returncode == 0 and len(same) == 10, f"{len(same)} of 10 robots' logs executed again to the bit"),
    ]
    return Outcome(claims, rms)


def real_time(seed: str, folder: Path) -> Outcome | None:
    """The first run of a seed in real time, of TRIES."""
    for number in range(TRIES):
        if (result := outcome(seed, folder / f"seed-{seed}-{number}")) is not None:
            return result
        print(f"void: seed {seed}: this machine was too busy for real time", flush=True)
    return None


def main() -> int:
    """Run each seed; returns the exit code, which is SKIPPED without a run in real time."""
    held, errors = list[bool](), list[float]()
    with tempfile.TemporaryDirectory() as folder:
        for seed in sys.argv[1:] or ["1"]:
            result = real_time(seed, Path(folder))
            if result is None:
                return SKIPPED
            errors.append(result.rms)
            for holds, claim in result.claims:
                print(f"{'passed' if holds else 'FAILED'}: seed {seed}: {claim}", flush=True)
                held.append(holds)
    rms = math.sqrt(sum(error * error for error in errors) / len(errors))
    most = OF_SEVERAL if len(errors) >= SEVERAL else OF_FEW
    listed = ", ".join(f"{error:.3f}" for error in errors)
    held.append(rms <= most)
    print(f"{'passed' if held[-1] else 'FAILED'}: separations off by {rms:.3f} m rms at the end ({most}): {listed}")
    print(f"{sum(held)} passed, {len(held) - sum(held)} failed", flush=True)
    return 0 if all(held) else 1


if __name__ == "__main__":
    sys.exit(main())
