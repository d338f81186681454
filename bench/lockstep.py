"""fes against the bare message pattern, in turn, on the same machine in the same minute."""

import json
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from console.launcher import free_port
from world import simulation
from world.scenario import load

ROUNDS = 3
PAYLOAD = 110  # bytes; a beacon of a robot with three links has 104, an observation with six peers 75
BUDGET = 0.6


def bare(n: int, ticks: int, peers: list[list[int]]) -> float:
    """Ticks per second of the bare pattern."""
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    module = [sys.executable, "-m", "bench.bare"]
    world = subprocess.Popen(
        [*module, "world", str(n), str(ticks), endpoint, str(PAYLOAD)], stdout=subprocess.PIPE, text=True
    )
    agents = [
        subprocess.Popen([*module, "agent", str(robot), endpoint, str(PAYLOAD), *map(str, peers[robot])])
        for robot in range(n)
    ]
    try:
        said, _ = world.communicate(timeout=120)
        for agent in agents:
            agent.wait(timeout=20)
    finally:
        children: list[subprocess.Popen[Any]] = [world, *agents]
        for child in children:
            if child.poll() is None:
                child.kill()
    return float(said)


def fes(scenario: Path, duration: float) -> float:
    """Ticks per second of a scenario in processes, without anybody watching."""
    with tempfile.TemporaryDirectory() as folder:
        words = [sys.executable, "-c", "from console.cli import main; main()", "run", str(scenario)]
        said = subprocess.run(
            [*words, "--headless", "--json", "--duration", str(duration), "--out", f"{folder}/run"],
            stdout=subprocess.PIPE,
            text=True,
            check=True,
            timeout=300,
        ).stdout
    return float(json.loads(said)["ticks_per_s"])


def in_range(scenario: Path) -> list[list[int]]:
    """Who is in range of whom at the scenario's start: the subscriptions that its robots hold."""
    state = simulation.start(simulation.create(load(scenario)))
    edges = state.proximity.edges
    return [edges.peers[span].tolist() for span in edges.spans]


def main() -> None:
    """Print rates and their ratio, round by round."""
    scenario = Path("configs/paper.toml")
    peers = in_range(scenario)
    n, duration = len(peers), 60.0
    ticks = round(duration / 0.02)
    rates = []
    print(f"lockstep, {n} robots in {n} processes, {np.mean([len(p) for p in peers]):.1f} peers in range each")
    for _ in range(ROUNDS):
        pair = bare(n, ticks, peers), fes(scenario, duration)
        rates.append(pair)
        print(f"  bare {pair[0]:7.0f} ticks/s    fes {pair[1]:7.0f} ticks/s    ratio {pair[1] / pair[0]:.2f}")
    ratio = statistics.median(ours / theirs for theirs, ours in rates)
    print(f"  median ratio {ratio:.2f}    budget >= {BUDGET} (paper.toml, with sub-steps)")


if __name__ == "__main__":
    main()
