"""Programs that print a number, each a process with one thread, and the processor time of commands."""

import os
import resource
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path

ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
"""Settings of libraries that would start threads of their own."""

LONGEST = 3600.0
"""Time after which a program is stopped [s]."""


class NotMeasured(Exception):
    """A row, or a part of it, that cannot be measured; the text is the reason."""


BYTECODE = {"PYTHONDONTWRITEBYTECODE": None}
"""Else each start of a program compiles its modules anew, which no installation does."""


def environment(variables: Mapping[str, str | None]) -> dict[str, str]:
    """The variables of this process with one thread and stored bytecode, and with `variables`; None removes one."""
    merged: dict[str, str | None] = {**os.environ, **ONE_THREAD, **BYTECODE, **variables}
    return {name: value for name, value in merged.items() if value is not None}


def output(words: Sequence[str | Path], variables: Mapping[str, str | None], folder: Path | None = None) -> str:
    """The standard output of a program; raises NotMeasured if it fails."""
    line = [str(word) for word in words]
    try:
        done = subprocess.run(
            line, cwd=folder, env=environment(variables), capture_output=True, text=True, timeout=LONGEST, check=False
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise NotMeasured(f"{line[0]}: {error}") from error
    if done.returncode:
        last = (done.stderr.strip() or done.stdout.strip()).splitlines()[-1:] or ["without a message"]
        raise NotMeasured(f"{Path(line[0]).name} ended with {done.returncode}: {last[0]}")
    return done.stdout


def number(words: Sequence[str | Path], variables: Mapping[str, str | None], folder: Path | None = None) -> float:
    """The number that a program prints last; raises NotMeasured if it prints none."""
    text = output(words, variables, folder)
    try:
        return float(text.split()[-1])
    except (IndexError, ValueError) as error:
        raise NotMeasured(f"a program printed no number, but {text[-80:]!r}") from error


def processor_time(words: Sequence[str | Path], variables: Mapping[str, str | None]) -> float:
    """Processor time of a command and its children [s]; no other child may end meanwhile."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    output(words, variables)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
