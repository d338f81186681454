"""CPU time until an agent is ready, and its memory."""

import re
import subprocess
import sys
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from console.backends.process_group import free_port

ROBOTS = 10

MEMORY = 60.0
"""Budget of an agent's resident memory [MB]."""


@dataclass(frozen=True)
class Started:
    """Agents that are ready."""

    ready: float
    """Time until all are [s]."""
    cpu: list[float]
    """Processor time of each until then [s]."""
    memory: list[float]
    """Resident memory of each [MB]."""


def start(
    python: str | Path = sys.executable,
    folder: Path | None = None,
    environment: Mapping[str, str] | None = None,
    program: str = "agents",
) -> Started:
    """Start a world and ten agents as `fes run` does, and measure the agents when all are ready.

    `python`, `folder`, `environment` and the agent's module `program` may be those of another version.
    """
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    words = [str(python), "-m", "world.process", "configs/paper.toml", "--rtf", "1", "-l", endpoint]
    world = subprocess.Popen(words, stderr=subprocess.PIPE, text=True, cwd=folder, env=environment)
    begun = time.perf_counter()
    agents = [
        subprocess.Popen(
            [str(python), "-m", program, "--id", str(robot), "-e", endpoint],
            stderr=subprocess.DEVNULL,
            cwd=folder,
            env=environment,
        )
        for robot in range(ROBOTS)
    ]
    assert world.stderr is not None
    try:
        for line in world.stderr:
            if "all robots are here" in line:
                break
        ready = time.perf_counter() - begun
        return Started(ready, [_cpu(agent.pid) for agent in agents], [_resident(agent.pid) for agent in agents])
    finally:
        world.terminate()
        children: list[subprocess.Popen[Any]] = [world, *agents]
        for process in children:
            process.communicate(timeout=20)


def main() -> None:
    """Print what ten agents take."""
    started = start()
    print(f"ten agents ready after {started.ready:.2f} s    budget < 5 s on two cores")
    print(f"an agent ready after {max(started.cpu):.2f} s of its own CPU    budget < 1 s")
    print(f"an agent's memory: {max(started.memory):.0f} MB resident    budget <= {MEMORY:g} MB")


def _cpu(pid: int) -> float:
    """CPU time so far [s]."""
    fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / 100.0


def _resident(pid: int) -> float:
    """Resident memory [MB]."""
    resident = re.search(r"VmRSS:\s+(\d+)", Path(f"/proc/{pid}/status").read_text())
    return int(resident[1]) / 1024.0 if resident else 0.0


if __name__ == "__main__":
    main()
