"""Reader of crafted files in a process of its own: `python -m tests.support.untrusted DIR`."""

import json
import os
import resource
import shutil
import sys
from collections.abc import Callable
from pathlib import Path

from console.connect import run_directory
from console.replay import log
from console.sweep import design, ledger
from fes.errors import FesError
from fes.transport.endpoints import DEFAULT_ENDPOINT
from tests.support.crafted import MIB
from tests.support.paths import CONFIGS
from world.execution import snapshot


def read_log(path: Path) -> None:
    list(log.load(path).ticks())


def read_ledger(header: Path, lines: Path) -> None:
    planned = design.plan(CONFIGS / "pair.toml", [], "0:1", [])
    where = header.parent.parent / "sweep"
    shutil.rmtree(where, ignore_errors=True)
    with ledger.opened(where, planned):
        pass
    for name, path in ((ledger.HEADER, header), (ledger.LINES, lines)):
        if path.exists():
            shutil.copyfile(path, where / name)
    with ledger.opened(where, planned):
        pass


def read_announcement(path: Path) -> None:
    """Read an announcement; a crafted one is skipped."""
    announced = path.parent.parent / "runs" / "x"
    announced.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(path, announced / run_directory.ENDPOINT)
    os.chdir(path.parent.parent)
    if run_directory.find("main") == run_directory.Address(DEFAULT_ENDPOINT, "main"):
        raise FesError("nothing is announced")


NOTHING = Path("nothing")
READERS: dict[str, list[Callable[[Path], object]]] = {
    "logs": [read_log],
    "states": [snapshot.read],
    "lines": [lambda path: read_ledger(path.parent / NOTHING, path)],
    "tables": [lambda path: read_ledger(path, path.parent / NOTHING), read_announcement],
}


def peak() -> float:
    """Peak memory of this process [MiB]."""
    status = Path("/proc/self/status")
    if not status.exists():
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / MIB  # in bytes on macOS
    return next(int(line.split()[1]) for line in status.read_text().splitlines() if line.startswith("VmHWM")) / 1024


def main() -> None:
    """Read all files below a folder; print the outcome of each and the peak memory as JSON."""
    where = Path(sys.argv[1])
    ends = list[tuple[str, str, str]]()
    for kind, readers in READERS.items():
        for path in sorted((where / kind).iterdir()):
            for reader in readers:
                try:
                    reader(path)
                    ends.append((kind, path.name, ""))
                except FesError as error:
                    ends.append((kind, path.name, str(error)))
    print(json.dumps({"ends": ends, "peak": peak()}))


if __name__ == "__main__":
    main()
