"""Rates of fes and of the bare message pattern, measured alternately on the same machine in the same minute."""

import json
import resource
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from bench.speed import robot
from console.backends.process_group import free_port
from world.config.scenario import load
from world.simulation import truth

ROUNDS = 3
PAYLOAD = 110  # bytes; a beacon of a robot with three links has 104, an observation with six peers 75
BUDGET, BUDGET_NUMPY = 0.75, 0.35
"""Wanted ratios to the bare messages, with the compiled core and without."""
SHORT = 25
"""Ticks of a run that measures the CPU time of the start."""


def bare(n: int, ticks: int, peers: list[list[int]], agent: float = 0.0, world: float = 0.0) -> float:
    """Ticks per second of the bare pattern, if `agent` and `world` spin for that long [s] in each tick."""
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    module = [sys.executable, "-m", "bench.speed.bare"]
    world_process = subprocess.Popen(
        [*module, "world", str(n), str(ticks), endpoint, str(PAYLOAD), str(world)], stdout=subprocess.PIPE, text=True
    )
    agents = [
        subprocess.Popen([*module, "agent", str(robot), endpoint, str(PAYLOAD), str(agent), *map(str, peers[robot])])
        for robot in range(n)
    ]
    try:
        output, _ = world_process.communicate(timeout=120)
        for child in agents:
            child.wait(timeout=20)
    finally:
        children: list[subprocess.Popen[Any]] = [world_process, *agents]
        for process in children:
            if process.poll() is None:
                process.kill()
    return float(output)


def fes(scenario: Path, duration: float, *flags: str, environment: Mapping[str, str] | None = None) -> float:
    """Ticks per second of a scenario in processes, without a viewer; `flags` are those of `fes run`."""
    with tempfile.TemporaryDirectory() as folder:
        words = [sys.executable, "-c", "from console.cli import main; main()", "run", str(scenario)]
        output = subprocess.run(
            [*words, "--headless", "--json", "--duration", str(duration), "--out", f"{folder}/run", *flags],
            stdout=subprocess.PIPE,
            text=True,
            check=True,
            timeout=300,
            env=environment,
        ).stdout
    return float(json.loads(output)["ticks_per_s"])


def in_range(scenario: Path) -> list[list[int]]:
    """Peers in range of each robot at the scenario's start: its subscriptions."""
    state = truth.start(truth.create(load(scenario)))
    edges = state.proximity.edges
    return [edges.peers[span].tolist() for span in edges.spans]


def spent(run: Callable[[], float]) -> tuple[float, float]:
    """The rate that `run` returns, and the CPU time of all its processes [s], their start included."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    rate = run()
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return rate, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    """Print rates, CPU times per tick without the start, and their ratios, round by round."""
    scenario = Path("configs/paper.toml")
    peers = in_range(scenario)
    n, duration = len(peers), 60.0
    ticks = round(duration / 0.02)
    costs = robot.measure(scenario)
    rates = []
    print(
        f"lockstep, {n} robots in {n} processes, {np.mean([len(p) for p in peers]):.1f} peers in range each [ticks/s]"
    )
    print("  bare: the messages alone; busy: the same, spinning for as long as a warm fes computes")
    _, bare_start = spent(lambda: bare(n, SHORT, peers))
    _, fes_start = spent(lambda: fes(scenario, SHORT * duration / ticks))
    for _ in range(ROUNDS):
        alone, alone_cpu = spent(lambda: bare(n, ticks, peers))
        busy = bare(n, ticks, peers, costs.robot, costs.world_tick)
        ours, ours_cpu = spent(lambda: fes(scenario, duration))
        per_tick = 1e3 * (np.array([alone_cpu, ours_cpu]) - (bare_start, fes_start)) / (ticks - SHORT)
        rates.append((ours / alone, ours / busy, per_tick[0] / per_tick[1]))
        print(
            f"  bare {alone:6.0f}    busy {busy:6.0f}    fes {ours:6.0f}    "
            f"fes/bare {ours / alone:.2f}    fes/busy {ours / busy:.2f}    "
            f"CPU per tick: bare {per_tick[0]:.1f} ms, fes {per_tick[1]:.1f} ms"
        )
    to_bare, to_busy, of_cpu = np.median(rates, axis=0)
    budget = f"budget >= {BUDGET}, without the compiled core {BUDGET_NUMPY}; paper.toml, with sub-steps"
    print(f"  median bare/fes of CPU time {of_cpu:.2f}")
    print(f"  median fes/bare {to_bare:.2f} ({budget}), fes/busy {to_busy:.2f}")


if __name__ == "__main__":
    main()
