"""Memory against the length of a run: python -m bench.size.memory [--ticks N] [--minutes M].

First N ticks of ten robots in one loop: world, crew, metrics and log, and a dashboard per simulated second. Then M
minutes of a world, ten agents and a viewer as processes. Resident memory is read twenty times. A line fitted through
the second half of the readings gives its growth.
"""

import argparse
import asyncio
import gc
import io
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from rich.console import Console

from console.backends import inprocess
from console.backends.process_group import free_port
from console.connect import observer
from console.dashboard import frame
from console.dashboard.history import ReportHistory
from fes.protocol import keys
from fes.recording.layout import NAME
from fes.transport import bus
from fes.transport.endpoints import Endpoints
from world.config.scenario import load
from world.execution.recorder import Recorder
from world.metrics import report_builder
from world.metrics.collector import MetricsCollector

SCENARIO = Path("configs/measured.toml")
READINGS = 20


def resident(pid: int | str = "self") -> float:
    """Resident memory of a process [MB]."""
    fields = Path(f"/proc/{pid}/statm").read_text().split()
    return int(fields[1]) * 4096 / 1e6


def growth(ticks: list[int], memory: list[float]) -> float:
    """MB per million ticks, over the second half of the readings."""
    half = len(ticks) // 2
    return float(np.polyfit(np.array(ticks[half:]) / 1e6, memory[half:], 1)[0])


def in_one_loop(ticks: int, recorded: bool) -> None:
    """Run everything in one process, and draw the dashboard every fiftieth tick."""
    scenario = load(SCENARIO, {"run.duration": ticks * 0.02})
    ticks_read: list[int] = []
    memory: list[float] = []
    alive = np.ones(scenario.robots.number, dtype=np.uint8)
    paper, history = Console(file=io.StringIO(), width=120, height=40), ReportHistory()
    with tempfile.TemporaryDirectory() as folder:
        recorder = Recorder(Path(folder) / NAME, scenario, "memory", "inprocess") if recorded else None
        metrics = MetricsCollector(scenario)
        for done, tick in enumerate(inprocess.ticks(scenario), 1):
            metrics.add(tick.state, tick.twists, tick.telemetry)
            if recorder is not None:
                recorder.add(metrics, tick.twists, inprocess.packed(tick), alive, 0.0)
            if done % 50 == 0:
                history.add(report_builder.build(metrics, "memory", alive, 0.02 * done, 50.0))
                paper.print(frame.render(history, 120, 40))
                paper.file = io.StringIO()
            if done % (ticks // READINGS) == 0:
                gc.collect()
                ticks_read.append(done)
                memory.append(resident())
    readings = " ".join(f"{value:.0f}" for value in memory)
    print(f"one loop, log {'on' if recorded else 'off'}: {readings} MB")
    print(f"  {growth(ticks_read, memory):+.2f} MB per million ticks", flush=True)


def in_processes(minutes: float) -> None:
    """Run a world with log and checkpoints, ten agents, and a viewer, at full speed."""
    with tempfile.TemporaryDirectory() as folder:
        out, endpoint = Path(folder) / "run", f"tcp/127.0.0.1:{free_port()}"
        words = {"world": ["world.process", str(SCENARIO), "--duration", "1e6", "--out", str(out), "-l", endpoint]}
        robots = load(SCENARIO).robots.number
        words |= {f"agent {robot}": ["agents.process", "--id", str(robot), "-e", endpoint] for robot in range(robots)}
        children = {
            name: subprocess.Popen([sys.executable, "-P", "-m", *line], stderr=subprocess.DEVNULL)
            for name, line in words.items()
        }
        try:
            asyncio.run(_watch({name: child.pid for name, child in children.items()}, endpoint, minutes))
        finally:
            children["world"].send_signal(signal.SIGINT)
            for child in children.values():
                child.wait()


async def _watch(pids: dict[str, int], endpoint: str, minutes: float) -> None:
    """Draw reports as the dashboard does, and read the memory of every process."""
    ticks: list[int] = []
    memory: dict[str, list[float]] = {name: [] for name in (*pids, "viewer")}
    paper, history = Console(file=io.StringIO(), width=120, height=40), ReportHistory()
    begun = time.monotonic()
    async with bus.opened(Endpoints("client", (endpoint,), timeout=30.0)) as opened:
        async for report in observer.reports(opened, keys.DEFAULT_RUN, 60.0, 1.0):
            if report is None:
                continue
            history.add(report)
            paper.print(frame.render(history, 120, 40))
            paper.file = io.StringIO()
            if time.monotonic() - begun >= 60.0 * minutes / READINGS * (len(ticks) + 1):
                ticks.append(report.tick)
                for name, pid in {**pids, "viewer": os.getpid()}.items():
                    memory[name].append(resident(pid))
            if len(ticks) == READINGS:
                break
    print(f"processes, {ticks[-1]:,} ticks in {minutes:g} minutes; first reading, last reading and growth:")
    for name, readings in memory.items():
        grows = f"{growth(ticks, readings):+8.2f} MB per million ticks"
        print(f"  {name:>8} {readings[0]:6.1f} {readings[-1]:6.1f} MB {grows}")


def main() -> None:
    """Print the readings."""
    parser = argparse.ArgumentParser(prog="python -m bench.size.memory", description=__doc__.splitlines()[0])
    parser.add_argument("--ticks", type=int, default=1_000_000)
    parser.add_argument("--minutes", type=float, default=20.0)
    flags = parser.parse_args()
    for recorded in (False, True):
        if flags.ticks:
            in_one_loop(flags.ticks, recorded)
    if flags.minutes:
        in_processes(flags.minutes)


if __name__ == "__main__":
    main()
