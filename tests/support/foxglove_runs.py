"""A run of two robots and `fes view --foxglove` beside it, as processes."""

import re
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from console.connect.run_directory import ENDPOINT
from fes.system import strict_json
from tests.support.processes import PATIENCE, fes, start, until

OUT = "out"

SETTINGS = ("--set", "run.dt=0.1", "--set", "run.duration=30")
"""The period of the Reports of a log is one tick then, so a log has every Report that an observer may receive."""


@dataclass
class Viewer:
    """A running `fes view --foxglove`."""

    process: "subprocess.Popen[str]"
    port: int

    def line(self) -> str:
        """The next line on standard error."""
        assert self.process.stderr is not None
        return self.process.stderr.readline()


@contextmanager
def running(where: Path, *words: str) -> Iterator["subprocess.Popen[str]"]:
    """A `fes run` that writes into the folder `out`, once it can be watched."""
    process = start(fes("run", *words, "--headless", "--json", "--out", OUT), where)
    try:
        until(lambda: (where / OUT / ENDPOINT).exists() or process.poll() is not None)
        assert process.poll() is None, process.communicate()
        yield process
    finally:
        if process.poll() is None:
            process.kill()
        process.communicate(timeout=PATIENCE)


@contextmanager
def viewer(where: Path) -> Iterator[Viewer]:
    """A viewer of the run in the folder `out`, at a free port."""
    endpoint = strict_json.loads((where / OUT / ENDPOINT).read_text())["endpoint"]
    process = start(fes("view", "--foxglove", "--port", "0", "--timeout", f"{PATIENCE:g}", "-e", endpoint), where)
    try:
        assert process.stderr is not None
        first = process.stderr.readline()
        address = re.search(r"ws://127\.0\.0\.1:(\d+),", first)
        assert address is not None, first + process.stderr.read()
        yield Viewer(process, int(address[1]))
    finally:
        if process.poll() is None:
            process.kill()
        process.communicate(timeout=PATIENCE)
