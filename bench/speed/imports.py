"""Processor time and memory of the imports of a program, by package.

`python bench/speed/imports.py [module]` imports nothing of fes but the module, by default that of an agent. So the
Python of another version can run it in its own folder. A module of the standard library counts for the package that
imported it first, for Python itself if that is fes.
"""

import gc
import json
import os
import subprocess
import sys
import time
from collections import defaultdict
from importlib import machinery
from pathlib import Path
from statistics import median
from typing import Any

PYTHON, FES, COMMAND = "Python", "fes", "command"
"""Names of rows: the interpreter with what fes imports of the standard library; our modules; the start of Python."""

GROUPS = {
    **dict.fromkeys(("agents", "console", "fes", "field", "world"), FES),
    **dict.fromkeys(("annotated_types", "pydantic_core", "typing_extensions", "typing_inspection"), "pydantic"),
}
"""Package -> row, where the row has another name."""

ROUNDS = 9

Cost = tuple[float, float]
"""Processor time [ms] and resident memory [MB]."""


def now() -> Cost:
    """Processor time and resident memory of this process."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return 1e3 * time.process_time(), pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def measure(module: str) -> dict[str, Cost]:
    """Cost of each row in this process, which imports `module`; garbage collection waits, as in `fes.process`."""
    start = now()
    gc.disable()
    times: defaultdict[str, float] = defaultdict(float, {PYTHON: start[0]})
    memory: defaultdict[str, float] = defaultdict(float, {PYTHON: start[1]})
    rows = [PYTHON]

    def charge(row: str) -> None:
        nonlocal start
        end = now()
        times[row] += end[0] - start[0]
        memory[row] += end[1] - start[1]
        start = end

    def wrap(loader: Any, name: str) -> None:
        original = getattr(loader, name)

        def wrapped(self: Any, given: Any) -> Any:
            charge(rows[-1])
            rows.append(row_of(getattr(given, "name", None) or given.__name__, rows[-1]))
            try:
                return original(self, given)
            finally:
                charge(rows.pop())

        setattr(loader, name, wrapped)

    wrap(machinery.SourceFileLoader, "exec_module")
    wrap(machinery.ExtensionFileLoader, "create_module")
    wrap(machinery.ExtensionFileLoader, "exec_module")
    __import__(module)
    charge(PYTHON)
    return {row: (times[row], memory[row]) for row in times}


def row_of(module: str, importer: str) -> str:
    """Row of a module that a module of the row `importer` imports."""
    package = module.partition(".")[0]
    if package in sys.stdlib_module_names or package.startswith("_"):
        return PYTHON if importer == FES else importer
    return GROUPS.get(package, package)


def main(module: str = "agents.process") -> None:
    """Print the medians of some processes."""
    words = [sys.executable, __file__, COMMAND, module]
    variables = {**os.environ, "PYTHONPATH": os.pathsep.join(["", *filter(None, [os.environ.get("PYTHONPATH")])])}
    variables.pop("PYTHONDONTWRITEBYTECODE", None)  # an installation has its bytecode
    costs = [json.loads(subprocess.check_output(words, env=variables)) for _ in range(ROUNDS + 1)][1:]
    rows = {row: tuple(median(cost[row][part] for cost in costs) for part in (0, 1)) for row in costs[0]}
    total = tuple(median(sum(cost[row][part] for row in cost) for cost in costs) for part in (0, 1))
    for row, (taken, memory) in [*sorted(rows.items(), key=lambda item: -item[1][0]), ("all", total)]:
        print(f"{row:10} {taken:6.0f} ms {memory:6.1f} MB")


if __name__ == "__main__":
    if sys.argv[1:2] == [COMMAND]:
        sys.path[0] = str(Path.cwd())
        print(json.dumps(measure(sys.argv[2])))
    else:
        main(*sys.argv[1:])
