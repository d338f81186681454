"""Commands of fes with a core: programs of one thread, the whole sweep, the lockstep, the start of agents."""

import subprocess
import sys
import tempfile
from pathlib import Path

from bench.against import old
from bench.against.cores import Core
from bench.against.programs import NotMeasured, environment, number, processor_time
from bench.speed import lockstep, startup
from bench.speed.startup import Started
from world.config.scenario import load

PAPER = Path("configs/paper.toml")

_FES = [sys.executable, "-c", "from console.cli import main; main()"]


def program(core: Core, *words: str | float) -> float:
    """The number that a program of `bench.against.ours` prints."""
    line = [sys.executable, "-m", "bench.against.ours", *(f"{word}" for word in words)]
    return number(line, core.variables)


def sweep(core: Core, seeds: int) -> float:
    """Robot-ticks per second of processor time of `fes sweep` with one process, its start and its report included."""
    with tempfile.TemporaryDirectory() as folder:
        flags = ["--seeds", f"0:{seeds}", "--jobs", "1", "--out", f"{folder}/sweep"]
        seconds = processor_time([*_FES, "sweep", str(PAPER), *flags], core.variables)
    scenario = load(PAPER)
    return seeds * scenario.ticks * scenario.robots.number / seconds


def processes(core: Core, seconds: float) -> float:
    """Ticks per second of the paper's ten robots in ten processes, over `seconds` of simulated time."""
    try:
        return lockstep.fes(PAPER, seconds, environment=environment(core.variables))
    except (subprocess.SubprocessError, OSError, ValueError) as error:
        raise NotMeasured(f"fes run: {error}") from error


def messages(peers: list[list[int]], seconds: float) -> float:
    """Ticks per second of the bare messages of as many robots and ticks."""
    try:
        return lockstep.bare(len(peers), round(seconds / load(PAPER).run.dt), peers)
    except (subprocess.SubprocessError, OSError, ValueError) as error:
        raise NotMeasured(f"bare messages: {error}") from error


def started(core: Core) -> Started:
    """Ten agents of this tree."""
    return startup.start(environment=environment(core.variables))


def started_old(folder: Path) -> Started:
    """Ten agents of the earlier commit."""
    python, place = old.python(folder), old.tree(folder)
    return startup.start(python, place, environment(old.VARIABLES), old.AGENT)
