"""CPU time until an agent is ready, and its memory."""

import re
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

from console.backends.process_group import free_port


def main() -> None:
    """Start a world and ten agents as `fes run` does, and measure them when all are ready."""
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    world = subprocess.Popen(
        [sys.executable, "-m", "world.process", "configs/paper.toml", "--rtf", "1", "-l", endpoint],
        stderr=subprocess.PIPE,
        text=True,
    )
    begun = time.perf_counter()
    agents = [
        subprocess.Popen(
            [sys.executable, "-m", "agents.process", "--id", str(robot), "-e", endpoint],
            stderr=subprocess.DEVNULL,
        )
        for robot in range(10)
    ]
    assert world.stderr is not None
    try:
        for line in world.stderr:
            if "all robots are here" in line:
                break
        ready = time.perf_counter() - begun
        cpu = [_cpu(agent.pid) for agent in agents]
        memory = [_resident(agent.pid) for agent in agents]
    finally:
        world.terminate()
        children: list[subprocess.Popen[Any]] = [world, *agents]
        for process in children:
            process.communicate(timeout=20)
    print(f"ten agents ready after {ready:.2f} s    budget < 5 s on two cores")
    print(f"an agent ready after {max(cpu):.2f} s of its own CPU    budget < 1 s")
    print(f"an agent's memory: {max(memory):.0f} MB resident    budget <= 80 MB")


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
