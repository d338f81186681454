"""Stop signals: ignored ones of a background program, and those before a command has a result."""

import asyncio
import signal
import socket
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from console import __main__ as entry
from console import cli
from fes import process
from fes.system import signals
from tests.support.paths import CONFIGS
from tests.support.processes import PATIENCE, alive, fes, first_report, start, started

WITHOUT_LOOP = """
import sys
from fes import process
with process.interruptible():
    print("ready", flush=True)
    print(sys.stdin.readline(), flush=True)
    sys.stdin.readline()
"""

UNINTERRUPTED = """
import sys
from fes import process
with process.interruptible():
    with process.uninterrupted():
        print("ready", flush=True)
        print(sys.stdin.readline(), flush=True)
    print("not reached", flush=True)
"""

WITH_LOOP = """
import asyncio, sys
from fes import process
async def main():
    print("ready", flush=True)
    print(await asyncio.to_thread(sys.stdin.readline), flush=True)
    await asyncio.Event().wait()
process.supervise(main)
"""


def ignoring(*numbers: signal.Signals) -> Callable[[], None]:
    """Code that makes a new process ignore these signals, as `nohup` and a background job of a script do."""

    def ignore() -> None:
        for number in numbers:
            signal.signal(number, signal.SIG_IGN)

    return ignore


@pytest.mark.parametrize("program", [WITHOUT_LOOP, WITH_LOOP], ids=["without a loop", "with a loop"])
def test_a_signal_that_a_program_was_started_to_ignore_does_not_stop_it(program: str) -> None:
    running = subprocess.Popen(
        [sys.executable, "-c", program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        text=True, preexec_fn=ignoring(signal.SIGHUP, signal.SIGINT),
    )  # fmt: skip
    assert running.stdin is not None
    assert running.stdout is not None
    assert running.stdout.readline() == "ready\n"
    for number in (signal.SIGHUP, signal.SIGINT):
        running.send_signal(number)
    running.stdin.write("it runs\n")
    running.stdin.flush()
    assert running.stdout.readline() == "it runs\n"
    running.send_signal(signal.SIGTERM)
    _, err = running.communicate(timeout=PATIENCE)
    assert running.returncode == 1
    assert err.endswith("fes.errors.Stopped: stopped by SIGTERM\n")


def test_a_signal_waits_for_the_end_of_an_uninterrupted_block() -> None:
    running = subprocess.Popen(
        [sys.executable, "-c", UNINTERRUPTED], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        text=True,
    )  # fmt: skip
    assert running.stdin is not None
    assert running.stdout is not None
    assert running.stdout.readline() == "ready\n"
    running.send_signal(signal.SIGTERM)
    running.stdin.write("it runs\n")
    out, err = running.communicate(timeout=PATIENCE)
    assert out.split("\n")[0] == "it runs"
    assert "not reached" not in out
    assert err.endswith("fes.errors.Stopped: stopped by SIGTERM\n")


def test_a_background_run_of_a_script_ignores_ctrl_c_and_still_ends_its_world_in_order(
    tmp_path: Path,
) -> None:
    words = fes("run", str(CONFIGS / "pair.toml"), "--duration", "100000", "--out", "out", "--json")
    running = subprocess.Popen(
        words, cwd=tmp_path, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        preexec_fn=ignoring(signal.SIGHUP, signal.SIGINT),
    )  # fmt: skip
    try:
        pids = started(tmp_path, running, 2)
        for number in (signal.SIGHUP, signal.SIGINT):
            running.send_signal(number)
        asyncio.run(first_report(tmp_path / "out"))
        running.send_signal(signal.SIGTERM)
        _, err = running.communicate(timeout=PATIENCE)
    finally:
        running.kill()
    assert running.returncode == 1
    assert err.endswith("fes: error: stopped by SIGTERM; the results so far are in out\n")
    assert (tmp_path / "out" / "summary.json").exists()  # a world that had to be killed writes none
    assert not any(alive(pid) for pid in pids)


@pytest.mark.parametrize("words", [["set", "channel.reference_snr=5e6"], ["doctor"]], ids=lambda words: words[0])
def test_a_command_interrupted_before_it_has_a_result_fails_with_one_line(words: list[str], tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as silent:  # it accepts connections, and never answers
        silent.settimeout(PATIENCE)
        running = start(fes(*words, "-e", f"tcp/127.0.0.1:{silent.getsockname()[1]}"), tmp_path)
        asked, _ = silent.accept()
        with asked:
            running.send_signal(signal.SIGINT)
            out, err = running.communicate(timeout=PATIENCE)
    assert (running.returncode, out, err) == (1, "", "fes: error: stopped by SIGINT\n")


def test_a_stopped_service_exits_with_0() -> None:
    program = "import os, signal\nfrom fes import process\nasync def main():\n"
    program += "    import asyncio; os.kill(os.getpid(), signal.SIGTERM); await asyncio.Event().wait()\n"
    for flag, code, said in ((False, 0, ""), (True, 1, "x: error: stopped by SIGTERM\n")):
        leave = f"process.leave('x', main, needs_its_end={flag})"
        done = subprocess.run(
            [sys.executable, "-c", program + leave], capture_output=True, text=True, timeout=PATIENCE
        )
        assert (done.returncode, done.stdout, done.stderr) == (code, "", said)


def test_no_stop_signal_interrupts_a_program_that_has_its_result() -> None:
    with signals.restored():
        signals.ignore()
        assert signals.heard() == ()
        for number in signals.STOP_SIGNALS:
            signal.raise_signal(number)
    assert set(signals.heard()) <= set(signals.STOP_SIGNALS)


def test_the_program_fes_ignores_stop_signals_at_its_end_and_a_call_of_main_does_not(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(sys, "argv", ["fes", "--help"])
    with signals.restored():
        with pytest.raises(SystemExit):
            cli.main()
        assert set(signals.heard()) == set(signals.STOP_SIGNALS)
        with pytest.raises(SystemExit):
            entry.main()
        assert signals.heard() == ()


def test_a_program_whose_output_is_closed_still_has_its_exit_code() -> None:
    program = "from fes import process\nasync def main(): return 2\nprocess.leave('x', main)"
    words = ["sh", "-c", 'exec "$@" >&- 2>&-', "sh", sys.executable, "-c", program]
    assert subprocess.run(words, timeout=PATIENCE).returncode == process.UNMET
