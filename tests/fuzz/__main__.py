"""`python -m tests.fuzz SECONDS`: random messages into the core for so long, a new seed each minute.

The programs of the agents' reader and of the world's take turns.
"""

import itertools
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from tests.fuzz import build

ROUND = 60
"""Length of a run with one seed [s]."""


def main() -> int:
    """Run for the seconds on the command line; returns an exit code."""
    seconds = int(sys.argv[1]) if len(sys.argv) > 1 else 600
    begun, seed = time.monotonic(), int(time.time())
    with tempfile.TemporaryDirectory() as folder:
        programs = [build.build(name, Path(folder)) for name in build.PROGRAMS]
        turns = itertools.cycle(programs)
        while (left := seconds - (time.monotonic() - begun)) >= 1.0:
            seed += 1
            program = next(turns)
            try:
                counts = build.run(program, int(min(ROUND, left)), seed)
                print(f"{program.name}, seed {seed}: {counts}", flush=True)
            except subprocess.CalledProcessError as error:
                print(f"{program.name}, seed {seed}: {error.stderr}")
                return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
