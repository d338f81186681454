"""The systemd units of deploy/: systemd can read them, and their run survives a stop."""

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
import tomli_w

from console.backends import inprocess
from console.backends.process_group import free_port
from console.connect import observer
from console.keys import certificates
from console.team.robot_tables import robot_tables
from console.team.table_run import free_datagram_port
from fes.protocol import keys
from fes.transport import bus
from fes.transport.endpoints import Endpoints
from tests.support import processes, robot_table, team_keys
from tests.support.commands import PROGRAMS
from tests.support.loop import load
from tests.support.paths import CONFIGS, ROOT
from tests.support.processes import PATIENCE, until
from world.execution.checkpoint import FOLDER, STATE

UNITS = ROOT / "deploy" / "systemd"
SECONDS = 10.0

Process = subprocess.Popen[Any]


def text(name: str) -> str:
    """A unit, with the paths of the programs under test."""
    return (UNITS / name).read_text(encoding="utf-8").replace("/opt/fes/bin/", f"{PROGRAMS}/")


def drop_in(name: str) -> str:
    """Further text of a unit for a run with certificates."""
    return text(f"{name}.d/keys.conf")


@pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="units: skipped, because there is no systemd")
@pytest.mark.parametrize("secure", [False, True])
def test_systemd_accepts_the_units(tmp_path: Path, secure: bool) -> None:
    templates = {f"fes-{kind}@3.service": f"fes-{kind}@.service" for kind in ("agent", "robot")}
    names = {"fes-world.service": "fes-world.service", **templates}
    for installed, name in names.items():
        (tmp_path / installed).write_text(text(name))
        if secure:
            (tmp_path / f"{installed}.d").mkdir()
            (tmp_path / f"{installed}.d/keys.conf").write_text(drop_in(name))
    done = subprocess.run(
        ["systemd-analyze", "verify", *(f"./{name}" for name in names)],
        cwd=tmp_path, capture_output=True, text=True, env=os.environ | {"SYSTEMD_UNIT_PATH": f"{tmp_path}:"},
    )  # fmt: skip
    assert (done.returncode, done.stdout + done.stderr) == (0, "")


def command(unit: str, environment: dict[str, str], instance: str = "") -> list[str]:
    """The command of a unit, with variables and instance expanded as by systemd; the last ExecStart holds."""
    *_, result = re.findall(r"^ExecStart=((?:.*\\\n)*.*)", unit, re.MULTILINE)
    words = []
    for word in shlex.split(result.replace("\\\n", " ")):
        if word.startswith("$") and word[1:] in environment:  # alone, it is split
            words += environment[word[1:]].split()
        else:
            filled = re.sub(r"\$\{(\w+)\}", lambda match: environment[match[1]], word)
            words.append(filled.replace("%i", instance))
    return words


def start(unit: str, environment: dict[str, str], log: Path, instance: str = "") -> Process:
    with log.open("a") as out:
        return subprocess.Popen(
            command(unit, environment, instance),
            cwd=log.parent, env=os.environ | environment, stdin=subprocess.DEVNULL, stdout=out, stderr=out,
        )  # fmt: skip


async def reached(endpoint: str, tick: int) -> None:
    """Wait until a run has reached a tick."""
    async with bus.opened(Endpoints("client", (endpoint,))) as opened:
        async for report in observer.reports(opened, keys.DEFAULT_RUN, PATIENCE, PATIENCE):
            if report is not None and report.tick >= tick:
                return


def test_a_world_that_is_stopped_and_started_resumes_and_its_robots_have_waited(tmp_path: Path) -> None:
    what = (CONFIGS / "pair.toml").read_text(encoding="utf-8")
    (tmp_path / "scenario.toml").write_text(re.sub(r"(?m)^duration = \S+", f"duration = {SECONDS}", what))
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    environment = {
        "STATE_DIRECTORY": str(tmp_path), "FES_SCENARIO": str(tmp_path / "scenario.toml"),
        "FES_FLAGS": f"-l {endpoint} --rtf 2",
    }  # fmt: skip
    own = {"FES_ROUTER": endpoint, "FES_FLAGS": "--timeout 60"}
    world = start(text("fes-world.service"), environment, tmp_path / "world.log")
    running = [world, *(start(text("fes-agent@.service"), own, tmp_path / "agents.log", robot) for robot in "01")]
    try:
        log_path = tmp_path / "world.log"
        until(lambda: "scenario starts" in log_path.read_text())
        asyncio.run(reached(endpoint, 20))
        world.terminate()
        assert world.wait(PATIENCE) == 0
        assert (tmp_path / "run" / FOLDER / STATE).exists()
        running.append(start(text("fes-world.service"), environment, log_path))
        assert [process.wait(PATIENCE) for process in running] == [0, 0, 0, 0], log_path.read_text()
    finally:
        for process in running:
            if process.poll() is None:
                process.kill()
                process.wait()
    assert "scenario resumes at tick" in log_path.read_text()
    summary = json.loads((tmp_path / "run/summary.json").read_text())
    assert summary["digest"] == inprocess.run(load("pair.toml", run__duration=SECONDS), "pair")["digest"]


def variables(unit: str) -> dict[str, str]:
    """The variables of a unit; of two lines with one variable the last holds."""
    lines = re.findall(r"^Environment=(.*)$", unit, re.MULTILINE)
    pairs = (pair.partition("=") for line in lines for pair in shlex.split(line))
    return {name: value for name, _, value in pairs}


def handed(unit: str, issued: Path, where: Path) -> None:
    """Credentials of a unit, in a directory of their own, as systemd provides them."""
    where.mkdir()
    for name, path in re.findall(r"^LoadCredential=(.*):/etc/fes/(?:keys/)?(.*)$", unit, re.MULTILINE):
        shutil.copy(issued / path, where / name)
        (where / name).chmod(0o440)


def test_with_the_drop_ins_a_run_uses_tls_and_each_unit_its_own_files(tmp_path: Path) -> None:
    what = (CONFIGS / "pair.toml").read_text(encoding="utf-8")
    (tmp_path / "scenario.toml").write_text(re.sub(r"(?m)^duration = \S+", f"duration = {SECONDS}", what))
    issued = team_keys.directory(tmp_path / "issued", certificates.create(1.0), ["world", "observer", "robot-0-1"])
    crew = "0-1"
    units = {
        "world": text("fes-world.service") + drop_in("fes-world.service"),
        "agent": text("fes-agent@.service") + drop_in("fes-agent@.service"),
    }
    units["world"] = re.sub(
        r"(?m)^#(LoadCredential=robot-)0-4(.crt:.*robot-)0-4", rf"\g<1>{crew}\g<2>{crew}", units["world"]
    )
    running = []
    port = free_port()
    for role, unit in units.items():
        own = tmp_path / role
        handed(unit.replace("%i", crew), issued, own)
        unit = unit.replace("%d", str(own)).replace("127.0.0.1:7447", f"127.0.0.1:{port}")
        environment = variables(unit) | {"STATE_DIRECTORY": str(tmp_path)}
        if role == "world":
            environment["FES_SCENARIO"] = str(tmp_path / "scenario.toml")
        running.append(start(unit, environment, tmp_path / f"{role}.log", crew))
    try:
        ends = [process.wait(PATIENCE) for process in running]
    finally:
        for process in running:
            if process.poll() is None:
                process.kill()
                process.wait()
    logs = "".join((tmp_path / f"{role}.log").read_text() for role in units)
    assert ends == [0, 0], logs
    assert "others on this machine" not in logs
    assert f"tls/127.0.0.1:{port}" in logs
    summary = json.loads((tmp_path / "run/summary.json").read_text())
    assert summary["digest"] == inprocess.run(load("pair.toml", run__duration=SECONDS), "pair")["digest"]
    names = {role: {path.name for path in (tmp_path / role).iterdir()} for role in units}
    assert names == {
        "world": {"ca.crt", "world.crt", "world.key", "robot-0-1.crt"},
        "agent": {"ca.crt", "robot-0-1.crt", "robot-0-1.key"},
    }


@pytest.mark.parametrize("secure", [False, True])
def test_a_real_robot_needs_only_the_files_of_its_unit_and_ends_when_told_to(tmp_path: Path, secure: bool) -> None:
    near, radio = f"tcp/127.0.0.1:{free_port()}", f"127.0.0.1:{free_datagram_port()}"
    tables = robot_tables(load("tabletop.toml"), keys.DEFAULT_RUN, near, radio)
    tables["radio"]["key_file"] = "team.key"
    issued = team_keys.directory(tmp_path / "issued", certificates.create(1.0), ["world", "robot-3"])
    programs = {"table": processes.command("world.tabletop.process", "tabletop", "-l", near, "--radio", radio)}
    unit, expected = text("fes-robot@.service"), {"robot.toml", "team.key"}
    if secure:
        endpoint = tables["team"]["endpoint"] = f"tls/127.0.0.1:{free_port()}"
        programs["router"] = processes.fes("team", "router", "-l", endpoint, "--keys", str(issued))
        unit += drop_in("fes-robot@.service")
        expected |= {"ca.crt", "robot-3.crt", "robot-3.key"}
    (issued / "robot.toml").write_text(tomli_w.dumps(tables))
    (issued / "team.key").write_text("0123456789abcdef\n")
    own, state, log = tmp_path / "credentials", tmp_path / "state", tmp_path / "robot.log"
    handed(unit.replace("%i", "3"), issued, own)
    environment = variables(unit) | {"STATE_DIRECTORY": str(state), "CREDENTIALS_DIRECTORY": str(own)}
    running: list[Process] = []
    try:
        for name, words in programs.items():
            with (tmp_path / f"{name}.log").open("w") as out:
                running.append(subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=out, stderr=out))
        robot = start(unit, environment, log, "3")
        running.append(robot)
        until(lambda: "ready: run" in log.read_text() or robot.poll() is not None)
        robot.terminate()
        assert robot.wait(PATIENCE) == 0, log.read_text()
    finally:
        for process in reversed(running):
            robot_table.end(process)
    assert f"team network at {tables['team']['endpoint']}" in log.read_text()
    assert [path.name for path in state.iterdir()] == ["robot-3.mcap"]
    assert {path.name for path in own.iterdir()} == expected
