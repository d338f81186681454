"""The Python interface in plain scripts: processes, interrupts, progress in a terminal."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

import fes
from tests.support.paths import ROOT
from tests.support.processes import PATIENCE, alive, children, until
from tests.support.processes import fes as fes_command
from tests.support.python_runs import arrays, of_machine
from tests.support.terminals import Terminal, is_restored

LAST_WORDS = """
import json, os, threading
from pathlib import Path
tasks = Path("/proc/self/task").glob("*/children")
children = "".join(path.read_text() for path in tasks).split()
lines = [Path(f"/proc/{child}/cmdline").read_bytes() for child in children]
for thread in threading.enumerate():
    if thread.name.startswith("asyncio-waitpid"):
        thread.join(10)
print(json.dumps({
    "error": error,
    "threads": [thread.name for thread in threading.enumerate()],
    "children": [str(line) for line in lines if b"resource_tracker" not in line],
    "sockets": [path.name for path in Path("/proc/self/fd").iterdir() if path.is_socket()],
    "files": sorted(os.listdir()),
}))
"""
"""The end of a script: its error, and what a call left behind.

Python's own resource_tracker of multiprocessing ends with the script. Python's own thread that waits for a process
reports the end of the process shortly before its own."""

INTERRUPTED = """
import fes, sys
def show(done, total):
    if done and not shown:
        shown.append(print("running", flush=True))
shown, error = [], None
try:
    CALL
except KeyboardInterrupt as interrupt:
    error = [type(interrupt).__name__, *getattr(interrupt, "__notes__", [])]
"""

CALLS = {
    "in one loop": 'fes.run("pair", duration=1e5, out="out", progress=show)',
    "in processes": 'fes.run("pair", duration=1e5, backend="processes", out="out", progress=show)',
    "in temporary processes": 'fes.run("pair", duration=1e5, backend="processes", progress=show)',
    "a sweep": 'fes.sweep("pair", seeds=range(50), overrides={"run.duration": 200}, progress=show, out="out")',
}


def environment(where: Path) -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": str(ROOT), "TMPDIR": str(where)}


def script(where: Path, text: str) -> list[str]:
    (where / "script.py").write_text(text)
    return [sys.executable, "script.py"]


def called(where: Path, words: list[str]) -> "subprocess.CompletedProcess[str]":
    return subprocess.run(
        words, cwd=where, env=environment(where), capture_output=True, text=True, timeout=PATIENCE, check=False
    )


@pytest.mark.parametrize("robots", [1, 5])
def test_processes_and_one_loop_give_the_same_arrays(robots: int, tmp_path: Path) -> None:
    loop = fes.run("paper", seed=2, duration=1.0)
    processes = fes.run(
        "paper", seed=2, duration=1.0, backend="processes", agents_per_process=robots, out=tmp_path / "out"
    )
    assert arrays(processes) == arrays(loop) == arrays(fes.read(tmp_path / "out"))
    assert processes.summary["backend"] == "processes"
    assert of_machine(processes.summary) == of_machine(loop.summary)
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert {"scenario.toml", "summary.json", "run.mcap", "world.log"} <= names


@pytest.mark.parametrize("call", CALLS.values(), ids=CALLS)
def test_an_interrupted_script_keeps_no_process_thread_or_session(call: str, tmp_path: Path) -> None:
    words = script(tmp_path, INTERRUPTED.replace("CALL", call) + LAST_WORDS)
    running = subprocess.Popen(
        words, cwd=tmp_path, env=environment(tmp_path), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert running.stdout is not None
    assert running.stdout.readline() == "running\n"
    offspring = children(running.pid)
    running.send_signal(signal.SIGINT)
    out, err = running.communicate(timeout=PATIENCE)
    left = json.loads(out)
    assert (running.returncode, err) == (0, "")
    assert left["error"][0] == "KeyboardInterrupt"
    assert (left["threads"], left["children"], left["sockets"]) == (["MainThread"], [], [])
    until(lambda: not any(map(alive, offspring)))
    if "out=" not in call:
        assert left["files"] == ["script.py"]
    elif "sweep" in call:
        assert left["error"][1].endswith("runs are done; the same call resumes the sweep")
    else:
        assert left["error"][1:] == ["interrupted; the results so far are in out"]
        assert len(fes.read(tmp_path / "out").time) > 0


def test_a_run_fails_with_the_words_of_its_processes_and_keeps_their_logs(tmp_path: Path) -> None:
    text = """
import fes, fes.errors, os, signal
from pathlib import Path
killed = []
def kill(done, total):
    if not done or killed:
        return
    for path in Path("/proc/self/task").glob("*/children"):
        for child in path.read_text().split():
            if b"world" in Path(f"/proc/{child}/cmdline").read_bytes():
                os.kill(int(child), signal.SIGKILL)
                killed.append(child)
                return
error = None
try:
    fes.run("pair", duration=1e5, backend="processes", progress=kill)
except fes.errors.FesError as failure:
    error = str(failure)
"""
    done = called(tmp_path, script(tmp_path, text + LAST_WORDS))
    left = json.loads(done.stdout)
    assert "fes-world was ended by SIGKILL (its log: " in left["error"]
    [folder] = [tmp_path / name for name in left["files"] if name.startswith("fes-")]
    assert str(folder / "world.log") in left["error"]
    assert (folder / "world.log").exists()


def test_a_script_has_a_bar_in_a_terminal_and_none_in_a_pipe(tmp_path: Path) -> None:
    text = 'import fes\nfes.run("pair", duration=8.0, rtf=8.0)\nprint("done")\n'
    words = script(tmp_path, text)
    piped = called(tmp_path, words)
    assert (piped.stdout, piped.stderr) == ("done\n", "")
    terminal = Terminal(words, tmp_path, env=environment(tmp_path))
    terminal.wait_for("100%")
    terminal.wait_for("done")
    assert terminal.end() == 0
    assert is_restored(terminal.text)


def test_a_script_without_a_guard_may_call_sweep_and_its_tables_are_those_of_the_command(tmp_path: Path) -> None:
    text = """
import fes
print("once")
table = fes.sweep("pair", {"formation.rule": ["disk", "two_nearest"]}, seeds=range(2),
                  overrides={"run.duration": 0.4}, jobs=2, out="python")
"""
    done = called(tmp_path, script(tmp_path, text))
    assert (done.returncode, done.stdout, done.stderr) == (0, "once\n", "")
    fields = ["--axis", "formation.rule=disk,two_nearest", "--set", "run.duration=0.4"]
    command = called(tmp_path, fes_command("sweep", "pair", "--seeds", "0:2", *fields, "--out", "command"))
    assert command.returncode == 0, command.stderr
    for name in ("table.csv", "cells.csv", "differences.csv", "sweep.json"):
        assert (tmp_path / "python" / name).read_bytes() == (tmp_path / "command" / name).read_bytes()
