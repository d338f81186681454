"""Stop signals during the start of a program: it ends soon, with one true message, and leaves no files.

The tests await each moment by its visible sign: an open library, a line, a child, a file.
"""

import json
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.support.paths import CONFIGS
from tests.support.processes import PATIENCE, STARTING, alive, children, fes, start, until

PAIR = str(CONFIGS / "pair.toml")
RUN = ["-m", "console", "run", PAIR, "--headless", "--json", "--duration", "1000"]
NUMPY = "_multiarray_umath"
"""A file of numpy: a process that has it open is still importing."""

Moment = Callable[[int, Path], object]


def loads(pid: int, library: str) -> bool:
    try:
        return library in Path(f"/proc/{pid}/maps").read_text()
    except OSError:
        return False


def agents(pid: int) -> list[int]:
    return [child for child, line in children(pid).items() if " -m agents " in line]


def world(pid: int) -> int | None:
    return next((child for child, line in children(pid).items() if " -m world " in line), None)


def log(where: Path) -> str:
    path = where / "runs" / "pair-1" / "world.log"
    return path.read_text() if path.exists() else ""


MOMENTS: dict[str, Moment] = {
    "while it imports": lambda pid, where: loads(pid, NUMPY),
    "when its world is there": lambda pid, where: world(pid),
    "while its world imports": lambda pid, where: loads(world(pid) or 0, NUMPY),
    "while its agents import": lambda pid, where: any(loads(agent, NUMPY) for agent in agents(pid)),
    "while its world waits": lambda pid, where: "waiting for" in log(where),
    "when it has begun": lambda pid, where: "all robots are here" in log(where),
}


SECURE = ("while its world imports", "while its agents import", "when it has begun")
"""Moments of a run with keys, which a run without keys does not cover."""


@pytest.mark.parametrize(
    ("moment", "secure"),
    [*((moment, False) for moment in MOMENTS), *((moment, True) for moment in SECURE)],
    ids=lambda value: {True: "secure", False: "plain"}.get(value, value),
)
def test_a_signal_at_any_moment_ends_a_run_quietly_and_leaves_only_its_results(
    moment: str, secure: bool, tmp_path: Path
) -> None:
    how = signal.SIGTERM if secure else signal.SIGINT
    running = start([sys.executable, *RUN, *(["--secure"] if secure else [])], tmp_path)
    try:
        until(lambda: MOMENTS[moment](running.pid, tmp_path))
        family = children(running.pid)
        running.send_signal(how)
        out, err = running.communicate(timeout=PATIENCE)
    finally:
        running.kill()
    assert not any(alive(pid) for pid in family)
    summary = tmp_path / "runs" / "latest" / "summary.json"
    reached = "; the results so far are in runs/pair-1" if summary.exists() else ""
    assert (running.returncode, out) == (1, "")
    assert err.removeprefix(STARTING.format(2)) == f"fes: error: stopped by {how.name}{reached}\n"
    if reached:
        assert json.loads(summary.read_text())["ticks"] > 0
        logs = "".join(path.read_text() for path in (tmp_path / "runs" / "pair-1").glob("*.log"))
        assert "Traceback" not in logs
        assert not (tmp_path / "runs" / "pair-1" / "keys").exists()
    else:
        assert not list(tmp_path.iterdir())


def test_a_run_stopped_before_its_first_tick_does_not_become_the_latest(tmp_path: Path) -> None:
    done = subprocess.run(
        fes("run", PAIR, "--backend", "inprocess", "--json", "--duration", "1"), cwd=tmp_path, capture_output=True
    )
    assert done.returncode == 0
    before = sorted(tmp_path.rglob("*"))
    running = start([sys.executable, *RUN], tmp_path)
    until(lambda: world(running.pid))
    assert (tmp_path / "runs" / "latest").readlink() == Path("pair-2")
    running.send_signal(signal.SIGINT)
    running.communicate(timeout=PATIENCE)
    assert sorted(tmp_path.rglob("*")) == before
    assert (tmp_path / "runs" / "latest").readlink() == Path("pair-1")


def test_a_second_signal_leaves_no_keys_no_endpoint_and_no_run_that_had_not_begun(tmp_path: Path) -> None:
    for moment in ("while its world imports", "when it has begun"):
        where = tmp_path / moment
        where.mkdir()
        running = start([sys.executable, *RUN, "--secure"], where)
        until(lambda: MOMENTS[moment](running.pid, where))  # noqa: B023
        family = children(running.pid)
        keys = where / "runs" / "pair-1" / "keys"
        assert (keys / "world.key").exists()
        running.send_signal(signal.SIGSTOP)  # so that it finds two signals at once
        running.send_signal(signal.SIGINT)
        running.send_signal(signal.SIGTERM)
        running.send_signal(signal.SIGCONT)
        _, err = running.communicate(timeout=PATIENCE)
        until(lambda: not any(alive(pid) for pid in family))  # noqa: B023
        assert not keys.exists()
        assert running.returncode == 130
        if moment == "when it has begun":
            assert err == STARTING.format(2) + "fes: error: stopped at once: the world closes runs/pair-1 by itself\n"
            assert not (where / "runs" / "pair-1" / "endpoint.json").exists()
            assert (where / "runs" / "pair-1" / "checkpoint").exists()
        else:
            assert err == STARTING.format(2)
            assert not list(where.iterdir())


@pytest.mark.parametrize(
    ("words", "how", "code", "said"),
    [
        (["console", "run", PAIR], signal.SIGINT, 1, "fes: error: stopped by SIGINT\n"),
        (["console", "--help"], signal.SIGTERM, 1, "fes: error: stopped by SIGTERM\n"),
        (["world", PAIR], signal.SIGINT, 0, ""),
        (["agents", "--id", "0"], signal.SIGINT, 0, ""),
    ],
    ids=["fes run", "fes", "fes-world", "fes-agent"],
)
def test_a_program_that_is_stopped_during_imports_prints_one_line(
    words: list[str], how: signal.Signals, code: int, said: str, tmp_path: Path
) -> None:
    running = start([sys.executable, "-m", *words], tmp_path)
    until(lambda: loads(running.pid, NUMPY) or running.poll() is not None)
    running.send_signal(how)
    out, err = running.communicate(timeout=PATIENCE)
    assert (running.returncode, out, err) == (code, "", said)
    assert not list(tmp_path.iterdir())


def test_fes_run_does_not_announce_a_start_if_it_starts_nothing(tmp_path: Path) -> None:
    (tmp_path / "used").touch()
    done = subprocess.run(fes("run", PAIR, "--out", "."), cwd=tmp_path, capture_output=True, text=True)
    assert done.stderr == "fes: error: --out .: the directory is not empty\n"
