"""A run whose robots compute by different cores, each in its own process, has the digest of one loop."""

import json
import os
import subprocess
from pathlib import Path

import pytest

from agents.core import compiled_crew
from console.backends import inprocess
from console.backends.process_group import free_port
from fes.arithmetic.core import library
from tests.support import cores
from tests.support.loop import load
from tests.support.paths import CONFIGS
from tests.support.processes import PATIENCE, command

pytestmark = cores.needs(compiled_crew.load())


def started(where: Path, core: str, *words: str) -> "subprocess.Popen[str]":
    """A program that is bound to one core."""
    return subprocess.Popen(
        command(*words),
        cwd=where,
        env=os.environ | {library.VARIABLE: core},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


@pytest.mark.parametrize(("scenario", "world"), [("paper", library.C), ("measured", library.NUMPY)])
def test_half_of_a_fleet_on_each_core_has_the_digest_of_one_loop(tmp_path: Path, scenario: str, world: str) -> None:
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    words = ("world.process", str(CONFIGS / f"{scenario}.toml"), "--duration", "3", "--out", "out", "-l", endpoint)
    processes = [started(tmp_path, world, *words)]
    try:
        for robots, core in (("0-4", library.C), ("5-9", library.NUMPY)):
            processes.append(started(tmp_path, core, "agents.process", "--id", robots, "-e", endpoint))
        for process in processes:
            _, err = process.communicate(timeout=PATIENCE)
            assert process.returncode == 0, err
    finally:
        for process in processes:
            if process.poll() is None:
                process.kill()
            process.communicate()
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    expected = inprocess.run(load(f"{scenario}.toml", run__duration=3.0), scenario)
    assert summary["digest"] == expected["digest"]
    assert summary["model_free"] == (scenario == "measured")
