"""The installed commands, called like a person or a script calls them."""

import json
import os
import socket
import subprocess
import sysconfig
from pathlib import Path
from typing import Any

from tests.support.paths import PAIR
from tests.support.processes import LOOP

PROGRAMS = Path(sysconfig.get_path("scripts"))


def call(where: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """The outcome of a command in the folder `where`."""
    command = [str(PROGRAMS / words[0]), *words[1:]]
    return subprocess.run(command, cwd=where, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=60)


def run_json(where: Path, *words: str) -> dict[str, Any]:
    """The summary that `fes run --json` prints, and nothing else."""
    done = call(where, "fes", "run", PAIR, "--backend", "inprocess", "--json", *words)
    assert (done.returncode, done.stderr) == (0, LOOP.format(2))
    summary: dict[str, Any] = json.loads(done.stdout)  # more than one document would not parse
    return summary


def complaint(done: subprocess.CompletedProcess[str], program: str) -> str:
    """The one line that an error is; the log lines of a service may stand before it."""
    assert done.returncode == 1, done
    assert done.stdout == ""
    *log, last = done.stderr.splitlines()
    assert all("waiting for the world" in line or line == LOOP.format(2).strip() for line in log), done.stderr
    assert len(log) <= 1
    assert last.startswith(f"{program}: error: ")
    return last.removeprefix(f"{program}: error: ")


def vacant() -> str:
    """An endpoint on the loopback interface without a listener."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return f"tcp/127.0.0.1:{probe.getsockname()[1]}"


def with_path(folder: Path, where: Path, *words: str) -> "subprocess.CompletedProcess[str]":
    """Outcome of an installed command with `folder` first on Python's path."""
    return subprocess.run(
        [str(PROGRAMS / words[0]), *words[1:]],
        cwd=where, env={**os.environ, "PYTHONPATH": str(folder)}, stdin=subprocess.DEVNULL, capture_output=True,
        text=True, timeout=60,
    )  # fmt: skip
