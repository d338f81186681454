"""Short runs by the command fes itself: in processes, and in one loop with other hash seeds."""

import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from fes.errors import FesError
from fes.extension import registry
from fes.system import strict_json
from world.config.scenario import Scenario
from world.metrics.summary import write_scenario

PATIENCE = 300.0
"""Longest duration of a run [s; wall clock]."""

PER_PROCESS = "2"
"""Robots of each agent process: neither alone, nor all of them."""

PROCESSES = ("--backend", "processes", "--agents-per-process", PER_PROCESS)
ONE_LOOP = ("--backend", "inprocess")


def run(scenario: Scenario, *flags: str, hash_seed: int) -> dict[str, Any]:
    """The summary of `fes run` in a process of its own; raises FesError with the last line that it prints."""
    with tempfile.TemporaryDirectory(prefix="fes-check-") as folder:
        write_scenario(Path(folder), scenario)
        uses = [word for module in registry.used() for word in ("--use", module)]
        words = ["run", "scenario.toml", "--out", "out", "--no-record", "--headless", "--json", *uses, *flags]
        path = os.pathsep.join(str(Path(entry).absolute()) for entry in sys.path)
        try:
            done = subprocess.run(
                [sys.executable, "-c", "from fes_robots import fes; fes()", *words],
                cwd=folder,
                env={**os.environ, "PYTHONPATH": path, "PYTHONHASHSEED": str(hash_seed)},
                stdin=subprocess.DEVNULL,
                capture_output=True,
                text=True,
                timeout=PATIENCE,
            )
        except subprocess.TimeoutExpired:
            raise FesError(f"a run of {scenario.run.duration:g} s takes longer than {PATIENCE:g} s") from None
    if done.returncode != 0:
        last = (done.stderr.strip().splitlines() or [f"exit code {done.returncode}"])[-1]
        raise FesError(last.removeprefix("fes: error: "))
    summary: dict[str, Any] = strict_json.loads(done.stdout)
    return summary
