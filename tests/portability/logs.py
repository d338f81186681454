"""Logs of some cases, recorded here and executed again elsewhere, to the bit.

`python -m tests.portability.logs record|execute FOLDER [--seconds S]`: a line for each case; exit code 1 if a log is
not repeated.
"""

import argparse
import sys
from pathlib import Path

from console.backends import inprocess
from console.replay import command, log
from fes.errors import FesError
from fes.recording.writer.log_file import LogFile
from tests.portability import cases
from world.execution.recorder import Recorder

CASES = (
    "paper",
    "measured",
    "variants/measured-shadowing",
    "variants/measured-faults",
    "variants/oracle-faults",
)


def record(path: Path, name: str, seconds: float) -> str:
    """Record a case; returns its digest."""
    scenario = cases.load(name, seconds)
    path.parent.mkdir(parents=True, exist_ok=True)
    # an emulated Python cannot start another one, so the log is written here
    with Recorder(path, scenario, name, "inprocess", writer=LogFile) as recorder:
        summary = inprocess.run(scenario, name, recorder=recorder)
        recorder.conclude(summary)
    return str(summary["digest"])


def execute(path: Path) -> str:
    """Execute the world and all robots of a log again, as `fes replay --all` does; returns the digest.

    Raises FesError with the first difference.
    """
    return str(command.rerun(log.load(path), all_robots=True)["digest"])


def main() -> int:
    """Print the lines; returns 1 if a log is not repeated."""
    parser = argparse.ArgumentParser(prog="python -m tests.portability.logs", description=__doc__)
    parser.add_argument("what", choices=["record", "execute"])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seconds", type=float, default=2.0, help="simulated time of each log")
    given = parser.parse_args()
    failed = 0
    for name in CASES:
        path = given.folder / f"{name}.mcap"
        try:
            digest = record(path, name, given.seconds) if given.what == "record" else execute(path)
            print(f"{name} {digest}", flush=True)
        except FesError as error:
            failed = 1
            print(f"{name} differs: {error}", flush=True)
    return failed


if __name__ == "__main__":
    sys.exit(main())
