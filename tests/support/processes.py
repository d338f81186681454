"""Real processes of a run: started, awaited and inspected."""

import contextlib
import json
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from console.connect import observer
from console.connect.run_directory import Address
from fes.transport import bus
from fes.transport.endpoints import Endpoints

PATIENCE = 120.0  # s; longest wait for an expected event, on a machine of any speed


STARTING = "starting a world and {} robots ...\n"
"""The first line of fes run, on standard error."""


LOOP = "running a world and {} robots in one loop ...\n"
"""The first line of fes run with one loop."""


def command(module: str, *words: str) -> list[str]:
    return [sys.executable, "-c", f"from {module} import main; main()", *words]


def fes(*words: str) -> list[str]:
    return command("console.cli", *words)


def start(words: list[str], where: Path) -> "subprocess.Popen[str]":
    return subprocess.Popen(
        words, cwd=where, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )


def children(pid: int) -> dict[int, str]:
    """Pid and command line of every child of a process; one that ends meanwhile may be missing."""
    processes = {}
    for task in Path(f"/proc/{pid}/task").glob("*/children"):
        with contextlib.suppress(OSError):  # the thread has ended
            for child in task.read_text().split():
                with contextlib.suppress(OSError):  # its parent has reaped it
                    line = Path(f"/proc/{child}/cmdline").read_bytes().replace(b"\0", b" ").decode()
                    processes[int(child)] = line
    return processes


def alive(pid: int) -> bool:
    """True if a process runs (a zombie does not)."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] not in "ZX"
    except OSError:
        return False


def until(holds: Callable[[], Any]) -> Any:
    """Wait for an effect of another process."""
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        value = holds()
        if value:
            return value
        time.sleep(0.01)
    raise AssertionError("what was waited for did not come")


def started(where: Path, running: "subprocess.Popen[str]", robots: int) -> dict[int, str]:
    """Wait until all robots have joined and the run has begun; returns the children."""
    log = where / "out" / "world.log"
    until(lambda: log.exists() and "all robots are here" in log.read_text())
    processes = children(running.pid)
    assert len(processes) == robots + 1
    return processes


async def first_report(directory: Path) -> None:
    """Wait until a run has executed some ticks, as seen by an observer."""
    address = Address(**json.loads((directory / "endpoint.json").read_text()))
    async with bus.opened(Endpoints("client", (address.endpoint,), timeout=PATIENCE)) as opened:
        async for report in observer.reports(opened, address.run, PATIENCE, PATIENCE):
            if report is not None and report.tick > 0:
                return
