"""The commands and the log of compose.yaml: the parts of a deployment that need no container engine."""

import re
import shutil
import signal
import subprocess
import tomllib
from pathlib import Path

from console.backends import inprocess
from fes.transport.identity import Identity
from tests.support import loop
from tests.support.commands import PROGRAMS
from tests.support.paths import ROOT
from world.config import expectations
from world.metrics import summary


def test_the_scenario_of_compose_reaches_its_formation_and_logs_it() -> None:
    run_summary = inprocess.run(loop.load("compose.toml"), "compose")
    assert not expectations.unmet(run_summary)
    assert expectations.unmet(inprocess.run(loop.load("compose.toml", run__duration=5.0), "compose"))


def test_log_lines_show_the_numbers_of_the_summary() -> None:
    run_summary = inprocess.run(loop.load("pair.toml", run__duration=20.0), "pair")
    text = "\n".join(summary.lines(run_summary))
    for number in (
        f"2 robots, seed 1: {run_summary['simulated_s']:g} s in",
        "1 links, r* = 68.114 m",
        f"largest separation error: {run_summary['separation_error_max']:.4f} m",
        f"largest estimate error: {run_summary['estimate_error_max']:.4f} m",
        f"reached at {run_summary['time_to']['separation_0_1m']:.2f} s",
        f"digest {run_summary['digest']}",
    ):
        assert number in text


def test_a_run_without_links_has_lines_without_errors() -> None:
    alone = loop.load("pair.toml", run__duration=0.5, channel__communication_range=10.0)
    lines = summary.lines(inprocess.run(alone, "pair"))
    assert "0 links" in lines[1]
    assert not any("largest" in line for line in lines)
    assert "separation error < 0.1 m: not reached" in lines


def test_compose_has_an_agent_for_each_robot_of_its_scenario_and_each_role_its_own_volume() -> None:
    robots = loop.load("compose.toml").robots.number
    text = (ROOT / "compose.yaml").read_text(encoding="utf-8")
    assert f"deploy: {{replicas: {robots}}}" in text
    assert f"issue-keys {robots} secure-world" in text
    secure = re.findall(
        r"secure-agent-(\d+):\n.*\n    command: fes-agent --id (\d+) --keys /keys/robot-(\d+) .*\n"
        r'    volumes: \["keys-robot-(\d+):/keys/robot-(\d+):ro"\]',
        text,
    )
    assert secure == [(str(robot),) * 5 for robot in range(robots)]
    made = re.search(r"seq -f robot-%g 0 (\d+)", (ROOT / "Dockerfile").read_text(encoding="utf-8"))
    assert made is not None
    assert int(made[1]) == robots - 1


def test_the_image_is_built_from_all_packages_of_the_wheel() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    packages = set(project["tool"]["hatch"]["build"]["targets"]["wheel"]["packages"])
    image, context = ((ROOT / name).read_text(encoding="utf-8") for name in ("Dockerfile", ".dockerignore"))
    copied = {word for line in re.findall(r"^COPY (?!--)(.+) \S+$", image, re.MULTILINE) for word in line.split()}
    assert packages
    assert packages <= copied
    assert copied == set(re.findall(r"^!(\S+)$", context, re.MULTILINE))


def test_keys_whose_creation_was_interrupted_are_created_again_once(tmp_path: Path) -> None:
    roles = ["world", "observer", "operator", "robot-0", "robot-1"]
    for role in ("authority", *roles):
        (tmp_path / role).mkdir(mode=0o700)
    script = (ROOT / "deploy/issue-keys").read_text(encoding="utf-8").replace("cd /keys", f"cd {tmp_path}")
    short = f"#!/bin/sh\n{PROGRAMS}/fes keys init --keys $8 && kill -9 $PPID\n"  # the robots' are still missing
    programs = tmp_path / "programs"
    programs.mkdir()
    (programs / "fes").write_text(short)
    (programs / "fes").chmod(0o700)

    def start() -> int:
        environment = {"PATH": f"{programs}:/usr/bin:/bin"}
        return subprocess.run(["/bin/sh", "-c", script, "issue-keys", "2", "lab.example"], env=environment).returncode

    assert start() == -signal.SIGKILL
    assert not (tmp_path / "world/world.crt").exists()
    (programs / "fes").unlink()
    (programs / "fes").symlink_to(PROGRAMS / "fes")
    assert start() == 0
    for role in roles:
        Identity(tmp_path / role, role).check()
        assert {path.name for path in (tmp_path / role).iterdir()} == {"ca.crt", f"{role}.crt", f"{role}.key"}
    before = (tmp_path / "robot-1/robot-1.crt").read_bytes()
    shutil.rmtree(tmp_path / "robot-0")
    (tmp_path / "robot-0").mkdir()
    assert start() == 0
    assert (tmp_path / "robot-1/robot-1.crt").read_bytes() == before
    Identity(tmp_path / "robot-0", "robot-0").check()


def test_every_published_port_is_on_the_loopback_interface() -> None:
    text = (ROOT / "compose.yaml").read_text(encoding="utf-8")
    ports = re.findall(r"^ *ports: \[(.*)\]$", text, re.MULTILINE)
    assert len(ports) == text.count("ports:") == 2
    assert all(port.startswith('"127.0.0.1:') and "," not in port for port in ports)
