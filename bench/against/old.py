"""Programs of the earlier commit, in an environment and a folder of its own."""

from pathlib import Path

from bench.against import environments
from bench.against.programs import number

RATE = """
import sys, time
from pathlib import Path
from types import SimpleNamespace
from bench import compute
from world.scenario import load

compute.time = SimpleNamespace(perf_counter=time.process_time)
scenario, ticks, skip = sys.argv[1:]
print(compute.rate(load(Path(scenario)), int(ticks), int(skip)))
"""
"""Prints in-process ticks per second of processor time: the commit's own function, with another clock."""

AGENT = "agents.process"
"""Module of its agent, which its command fes-agent runs."""

VARIABLES = environments.ISOLATED
"""Environment variables of its programs."""


def python(folder: Path) -> Path:
    """Its Python, made if necessary."""
    return environments.old(folder)


def tree(folder: Path) -> Path:
    """Its files."""
    return environments.tree(folder)


def rate(folder: Path, ticks: int, skip: int) -> float:
    """Ticks per second of `configs/paper.toml` in process."""
    words: list[str | Path] = [python(folder), "-c", RATE, "configs/paper.toml", str(ticks), str(skip)]
    return number(words, VARIABLES, tree(folder))
