"""Private keys of a killed run: named by the doctor, and removed by the next run."""

import json
import subprocess
from pathlib import Path

from console.doctor import machine
from console.keys import stale_keys
from tests.support.paths import CONFIGS
from tests.support.processes import LOOP, PATIENCE, alive, children, fes, start, until

PAIR = str(CONFIGS / "pair.toml")


def call(where: Path, *words: str) -> "subprocess.CompletedProcess[str]":
    return subprocess.run(fes(*words), cwd=where, capture_output=True, text=True, timeout=PATIENCE)


def seen_by_the_doctor(where: Path) -> list[tuple[str, str]]:
    findings = json.loads(call(where, "doctor", "--json").stdout)
    return [(row["status"], row["remedy"]) for row in findings if row["check"] == "private keys"]


def test_keys_left_by_a_killed_run_are_named_and_removed_and_those_of_a_running_run_are_not(tmp_path: Path) -> None:
    running = start(fes("run", PAIR, "--secure", "--headless", "--json", "--duration", "1000"), tmp_path)
    try:
        keys = tmp_path / "runs" / "pair-1" / "keys"
        until(lambda: len(children(running.pid)) == 3)
        family = children(running.pid)
        assert (keys / "robot-1.key").exists()
        short = ["run", PAIR, "--backend", "inprocess", "--json", "--duration", "0.1"]
        assert call(tmp_path, *short).stderr == LOOP.format(2)
        assert seen_by_the_doctor(tmp_path) == []
        assert (keys / "robot-1.key").exists()
    finally:
        running.kill()
        running.communicate()
    until(lambda: not any(alive(pid) for pid in family))
    assert (keys / "robot-1.key").exists()
    assert seen_by_the_doctor(tmp_path) == [("warning", "rm -r runs/pair-1/keys")]
    again = call(tmp_path, *short, "--out", "runs/pair-1")
    full = "--out runs/pair-1: the directory is not empty"
    left = "runs/pair-1/keys has the private keys of a run that was killed"
    assert again.stderr == f"fes: error: {full}; {left}\n"
    removed = "fes: warning: removed runs/pair-1/keys: private keys of a run that was killed\n"
    assert call(tmp_path, *short).stderr == LOOP.format(2) + removed
    assert not keys.exists()
    assert seen_by_the_doctor(tmp_path) == []


def test_keys_left_in_a_given_directory_are_named_when_it_is_used_again(tmp_path: Path) -> None:
    keys = tmp_path / "out" / "keys"
    keys.mkdir(parents=True)
    with stale_keys.marked(keys):
        assert stale_keys.remark(tmp_path / "out") == ""
    done = call(tmp_path, "run", PAIR, "--backend", "inprocess", "--out", "out")
    said = "--out out: the directory is not empty; out/keys has the private keys of a run that was killed"
    assert done.stderr == f"fes: error: {said}\n"


def test_keys_that_no_run_made_are_kept(tmp_path: Path) -> None:
    mine = tmp_path / "paper-1" / "keys"
    mine.mkdir(parents=True)
    (mine / "world.key").touch()
    assert stale_keys.remove(tmp_path) == []
    assert list(machine.private_keys(tmp_path)) == []
    assert (mine / "world.key").exists()
