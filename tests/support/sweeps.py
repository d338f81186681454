"""Sweeps of many runs, stopped midway."""

import json
import subprocess
import time
from pathlib import Path

from console.sweep import ledger
from tests.support.paths import PAIR

LONG = ["sweep", PAIR, "--seeds", "0:120", "--set", "run.duration=4", "--jobs", "2", "--out", "out"]


RUNS = 120


def finished(directory: Path) -> list[str]:
    """Keys of the complete lines of the ledger."""
    path = directory / ledger.LINES
    lines = path.read_bytes().split(b"\n")[:-1] if path.exists() else []
    return [json.loads(line)["key"] for line in lines]


def until_some_are_done(directory: Path, sweep: "subprocess.Popen[str]") -> None:
    while not finished(directory):
        assert sweep.poll() is None, sweep.communicate()
        time.sleep(0.005)
