"""The systemd units of deploy/: systemd can read them, and what they start is a run that survives a stop."""

import asyncio
import json
import os
import re
import shlex
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

from console import inprocess, observer
from console.launcher import free_port
from fes import bus, keys
from fes.endpoints import Endpoints
from tests.loop import CONFIGS, load
from tests.test_cli import PROGRAMS
from tests.test_processes import PATIENCE, until
from world.checkpoint import FOLDER, STATE

UNITS = Path(__file__).parent.parent / "deploy" / "systemd"
SECONDS = 10.0

Process = subprocess.Popen[Any]


def text(name: str) -> str:
    """A unit, with the programs where they are here."""
    return (UNITS / name).read_text(encoding="utf-8").replace("/opt/fes/bin/", f"{PROGRAMS}/")


@pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="units: skipped, because there is no systemd")
def test_systemd_finds_nothing_wrong_with_the_units(tmp_path: Path) -> None:
    (tmp_path / "fes-world.service").write_text(text("fes-world.service"))
    for number in (3, 4):
        (tmp_path / f"fes-agent@{number}.service").write_text(text("fes-agent@.service"))
    (tmp_path / "fes-agent@4.service.d").mkdir()
    (tmp_path / "fes-agent@4.service.d/keys.conf").write_text(text("keys.conf"))
    names = ["fes-world.service", "fes-agent@3.service", "fes-agent@4.service"]
    done = subprocess.run(
        ["systemd-analyze", "verify", *(f"./{name}" for name in names)],
        cwd=tmp_path, capture_output=True, text=True, env=os.environ | {"SYSTEMD_UNIT_PATH": f"{tmp_path}:"},
    )  # fmt: skip
    assert (done.returncode, done.stdout + done.stderr) == (0, "")


def command(name: str, environment: dict[str, str], instance: str = "") -> list[str]:
    """What a unit starts, its variables and its instance put in as systemd does."""
    found = re.search(r"^ExecStart=((?:.*\\\n)*.*)", text(name), re.MULTILINE)
    assert found is not None
    words = []
    for word in shlex.split(found[1].replace("\\\n", " ")):
        if word.startswith("$") and word[1:] in environment:  # alone, it is split
            words += environment[word[1:]].split()
        else:
            filled = re.sub(r"\$\{(\w+)\}", lambda match: environment[match[1]], word)
            words.append(filled.replace("%i", instance))
    return words


def start(name: str, environment: dict[str, str], log: Path, instance: str = "") -> Process:
    with log.open("a") as out:
        return subprocess.Popen(
            command(name, environment, instance),
            cwd=log.parent, env=os.environ | environment, stdin=subprocess.DEVNULL, stdout=out, stderr=out,
        )  # fmt: skip


async def reached(endpoint: str, tick: int) -> None:
    """Wait until a run has come so far."""
    async with bus.opened(Endpoints("client", (endpoint,))) as opened:
        async for report in observer.reports(opened, keys.DEFAULT_RUN, PATIENCE, PATIENCE):
            if report is not None and report.tick >= tick:
                return


def test_a_world_that_is_stopped_and_started_goes_on_and_its_robots_have_waited(tmp_path: Path) -> None:
    what = (CONFIGS / "pair.toml").read_text(encoding="utf-8")
    (tmp_path / "scenario.toml").write_text(re.sub(r"(?m)^duration = \S+", f"duration = {SECONDS}", what))
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    environment = {
        "STATE_DIRECTORY": str(tmp_path), "FES_SCENARIO": str(tmp_path / "scenario.toml"),
        "FES_FLAGS": f"-l {endpoint} --rtf 2",
    }  # fmt: skip
    own = {"FES_ROUTER": endpoint, "FES_FLAGS": "--timeout 60"}
    world = start("fes-world.service", environment, tmp_path / "world.log")
    running = [world, *(start("fes-agent@.service", own, tmp_path / "agents.log", robot) for robot in "01")]
    try:
        said = tmp_path / "world.log"
        until(lambda: "scenario starts" in said.read_text())
        asyncio.run(reached(endpoint, 20))
        world.terminate()
        assert world.wait(PATIENCE) == 0
        assert (tmp_path / "run" / FOLDER / STATE).exists()
        running.append(start("fes-world.service", environment, said))
        assert [process.wait(PATIENCE) for process in running] == [0, 0, 0, 0], said.read_text()
    finally:
        for process in running:
            if process.poll() is None:
                process.kill()
                process.wait()
    assert "scenario goes on at tick" in said.read_text()
    found = json.loads((tmp_path / "run/summary.json").read_text())
    assert found["digest"] == inprocess.run(load("pair.toml", run__duration=SECONDS), "pair")["digest"]
