"""FES_CORE in programs: an error is one line, and a core that is missing or cut off leaves the work to numpy."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from agents.core import compiled_crew
from console.backends.process_group import free_port
from fes.arithmetic.core import library
from tests.support import cores
from tests.support.paths import PAIR
from tests.support.processes import PATIENCE, command, fes

RUN = (PAIR, "--duration", "0.2")
WORD = "FES_CORE must be 'c' or 'numpy', got 'maybe'"
MISSING = "import fes.arithmetic.core.library as library; library.SUFFIX = '.missing'"
"""A program in which no library was built."""

CUT = """
import pathlib, shutil, sys, tempfile
import fes.arithmetic.core.library as library
complete = library._tested
def cut(path, test):
    short = pathlib.Path(tempfile.mkdtemp()) / path.name
    data = path.read_bytes()
    short.write_bytes(data[: len(data) // 2])
    result = complete(short, test)
    shutil.rmtree(short.parent)
    return result
library._tested = cut
"""
"""A program in which every library is cut off in the middle."""


def outcome(where: Path, core: str, words: list[str], before: str = "") -> "subprocess.CompletedProcess[str]":
    """The outcome of a program with FES_CORE, which executes some code first."""
    words = [*words[:2], f"{before}\n{words[2]}", *words[3:]]
    environment = os.environ | {library.VARIABLE: core}
    return subprocess.run(
        words, cwd=where, env=environment, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=PATIENCE
    )


@pytest.mark.parametrize("backend", ["inprocess", "processes"])
def test_another_word_ends_a_run_in_one_line(tmp_path: Path, backend: str) -> None:
    done = outcome(tmp_path, "maybe", fes("run", *RUN, "--headless", "--backend", backend))
    start, *lines = done.stderr.splitlines()
    assert done.returncode == 1
    assert start.endswith("...")
    assert [line.removeprefix("fes: error: ").removeprefix("fes-world: ") for line in lines] == [WORD]


def test_another_word_ends_a_world_and_an_agent_in_one_line(tmp_path: Path) -> None:
    done = outcome(tmp_path, "maybe", command("world.process", *RUN))
    assert (done.returncode, done.stderr.splitlines()[-1]) == (1, f"fes-world: error: {WORD}")
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    world = subprocess.Popen(command("world.process", *RUN, "-l", endpoint), cwd=tmp_path, stderr=subprocess.DEVNULL)
    try:
        done = outcome(tmp_path, "maybe", command("agents.process", "--id", "0", "-e", endpoint))
    finally:
        world.send_signal(signal.SIGKILL)
        world.wait(PATIENCE)
    assert (done.returncode, done.stderr.splitlines()[-1]) == (1, f"fes-agent: error: {WORD}")
    assert "Traceback" not in done.stderr


def test_a_core_that_is_demanded_but_was_not_built_ends_a_run_in_one_line(tmp_path: Path) -> None:
    done = outcome(tmp_path, library.C, fes("run", *RUN, "--headless", "--backend", "inprocess"), MISSING)
    assert done.returncode == 1
    message = done.stderr.splitlines()[-1]
    assert message.startswith("fes: error: FES_CORE is 'c', but the library '")
    assert message.endswith("' cannot be used: it was not built")
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize("before", [MISSING, pytest.param(CUT, marks=cores.needs(compiled_crew.load()))])
def test_a_core_that_cannot_be_used_leaves_the_digest_as_it_is(tmp_path: Path, before: str) -> None:
    if before == CUT and not sys.platform.startswith("linux"):
        pytest.skip("only a file of the format ELF is examined before it is loaded")
    digests = set()
    for core, code in (("", before), ("", ""), (library.NUMPY, "")):
        done = outcome(tmp_path, core, fes("run", *RUN, "--headless", "--backend", "inprocess"), code)
        assert done.returncode == 0, done.stderr
        digests.add(next(line for line in done.stdout.splitlines() if line.startswith("digest ")))
    assert len(digests) == 1
