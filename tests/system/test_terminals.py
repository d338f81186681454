"""Any terminal and any locale: the same exit codes, a restored terminal, and the result on it."""

import asyncio
import io
import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from console import cli
from tests.support import recordings
from tests.support.commands import PROGRAMS
from tests.support.loop import load
from tests.support.paths import CONFIGS, PAIR, ROOT
from tests.support.processes import PATIENCE, fes, first_report, until
from tests.support.terminals import ENTER, POSIX, Terminal, is_restored

LOOP = ["run", PAIR, "--backend", "inprocess"]
ARROW = os.fsdecode("→".encode())
"""A character outside ASCII, as the bytes of an argument in any locale."""


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a recorded run."""
    where = tmp_path_factory.mktemp("logs")
    recordings.record(where / "run.mcap", load("pair.toml", run__duration=1.0))
    return where


def written_by(stream: str, monkeypatch: pytest.MonkeyPatch, encoding: str) -> io.BytesIO:
    """Bytes written to a standard stream of this encoding, which rejects characters that it lacks."""
    kept = io.BytesIO()
    monkeypatch.setattr(sys, stream, io.TextIOWrapper(kept, encoding=encoding, errors="strict", write_through=True))
    return kept


@pytest.mark.parametrize("encoding", ["ascii", "latin-1"])
def test_every_command_prints_in_any_encoding_and_ends_as_under_utf_8(
    encoding: str, logs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    log = str(logs / "run.mcap")
    commands: list[tuple[int, list[str]]] = [
        (0, [*LOOP, "--duration", "1", "--seed", "7", "--out", "out"]),
        (0, [*LOOP, "--duration", "1", "--verbose", "--set", "channel.model=logistic"]),
        (2, [*LOOP, "--duration", "1", "--set", 'expect=[{of="ticks", below=1.0}]']),
        (1, [*LOOP, "--set", "run.μ=1"]),
        (0, ["replay", log, "--verbose", "--headless"]),
        (0, ["replay", log, "--all"]),
        (0, ["compare", log, log]),
        (1, ["compare", log, "out"]),
        (0, ["sweep", PAIR, "--seeds", "0:2", "--set", "run.duration=0.2", "--jobs", "1", "--out", "swept"]),
        (0, ["plot", log, "--out", "drawn"]),
        (0, ["schema"]),
        (0, ["keys", "init", "--robots", "1"]),
        (0, ["keys", "list"]),
        (0, ["claims", "weights"]),
        (0, ["--help"]),
        (1, ["walk→"]),
    ]
    # Every encoding has the characters of ASCII.
    for expected, words in commands if encoding == "ascii" else commands[:6]:
        for stream in ("stdout", "stderr"):
            written_by(stream, monkeypatch, encoding)
        monkeypatch.setattr(sys, "argv", ["fes", *words])
        with pytest.raises(SystemExit) as left:
            cli.main()
        assert left.value.code == expected, words


@pytest.mark.parametrize(
    ("words", "code"),
    [
        # with processes, and their logs
        (["fes", "run", PAIR, "--duration", "0.5", "--headless", "--out", ARROW], 0),
        (["fes", "doctor", "-e", "tcp/127.0.0.1:9"], 1),
        (["fes", "view", "-e", "tcp/127.0.0.1:9", "--timeout", "0.2"], 1),
        (["fes", "set", "channel.reference_snr=1", "-e", "tcp/127.0.0.1:9", "--timeout", "0.2"], 1),
        (["fes-world", f"nowhere{ARROW}.toml"], 1),
        (["fes-agent", "--id", ARROW], 1),
    ],
    ids=lambda value: "-".join(value[:2]) if isinstance(value, list) else "",
)
def test_a_process_without_utf_8_ends_as_with_it(words: list[str], code: int, tmp_path: Path) -> None:
    done = subprocess.run(
        [str(PROGRAMS / words[0]), *words[1:]],
        cwd=tmp_path,
        env={**os.environ, **POSIX},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        timeout=PATIENCE,
    )
    assert b"Traceback" not in done.stderr
    assert done.returncode == code, done.stderr
    assert done.stdout.isascii()
    assert done.stderr.isascii()


@pytest.mark.parametrize("env", [{"PYTHONIOENCODING": "latin-1"}, POSIX])
def test_a_terminal_without_utf_8_shows_frames_and_is_restored(env: dict[str, str], tmp_path: Path) -> None:
    shown = Terminal(fes(*LOOP, "--duration", "0.5", "--out", "out"), tmp_path, env=env)
    assert shown.end() == 0, shown.text
    assert ENTER in shown.text
    assert is_restored(shown.text)
    assert "Traceback" not in shown.text
    assert "\nrun directory: out\n" in shown.left


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP, signal.SIGINT])
def test_a_signal_restores_the_terminal_and_leaves_the_last_frame_on_it(
    number: signal.Signals, tmp_path: Path
) -> None:
    shown = Terminal(fes(*LOOP, "--duration", "100000", "--rtf", "50", "--out", "out"), tmp_path)
    shown.wait_for("time ")
    shown.send(number)
    assert shown.end() == 1
    assert is_restored(shown.text)
    *frame, last = shown.left.rstrip("\n").split("\n")
    assert last == f"fes: error: stopped by {number.name}; the results so far are in out"
    assert any(line.startswith("pair ") for line in frame)


@pytest.mark.parametrize(("columns", "rows"), [(80, 24), (120, 40)])
def test_after_a_run_the_last_frame_and_the_headline_are_on_the_terminal_together(
    columns: int, rows: int, tmp_path: Path
) -> None:
    shown = Terminal(fes(*LOOP, "--duration", "2", "--out", "out"), tmp_path, columns, rows)
    assert shown.end() == 0
    lines = shown.left.rstrip("\n").split("\n")
    assert len(lines) < rows  # and the prompt
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert lines[0].startswith("pair  index oracle ")  # of the frame
    assert all(any(panel in line for line in lines) for panel in ("Map", "Convergence", "Links", "├"))
    end = [line.strip() for line in lines[-7:]]
    words = ("estimate error", "separation error", "r*", "time", "digest", "run dir", "2 robots, 1 link within")
    for line, word in zip(end, words, strict=True):
        assert line.startswith(word)
    assert end[-3] == f"digest  {summary['digest']}"
    assert end[-2] == "run directory: out"


def test_the_summary_of_a_large_run_has_at_most_20_lines_that_include_the_failures(tmp_path: Path) -> None:
    many = ", ".join(f'{{of="ticks", below={100.0 + k}}}' for k in range(30))
    wanted = f'expect=[{many}, {{of="robots", equals=3}}]'
    words = ["run", str(CONFIGS / "hundred.toml"), "--backend", "inprocess", "--duration", "0.2", "--headless"]
    shown = Terminal(fes(*words, "--set", wanted, "--out", "out"), tmp_path)
    assert shown.end() == 2
    lines = shown.left.rstrip("\n").split("\n")
    assert len(lines) <= 20
    assert [line for line in lines if "robots equal to 3.0: 100, does not hold" in " ".join(line.split())]


def test_ctrl_c_leaves_the_last_frame_of_a_view_and_its_figure(
    tmp_path: Path, endless: "subprocess.Popen[str]"
) -> None:
    until(lambda: (tmp_path / "out" / "endpoint.json").exists())
    asyncio.run(first_report(tmp_path / "out"))
    address = json.loads((tmp_path / "out" / "endpoint.json").read_text())["endpoint"]
    shown = Terminal(fes("view", "-e", address, "--picture", "last.svg"), tmp_path)
    shown.wait_for("tick ")
    shown.send(signal.SIGINT)
    assert shown.end() == 0
    assert is_restored(shown.text)
    lines = shown.left.rstrip("\n").split("\n")
    assert lines[0].startswith("pair ")
    assert len(lines) < 24
    assert "pair" in (tmp_path / "last.svg").read_text("utf-8")


def test_quitting_a_replay_leaves_its_last_frame(logs: Path, tmp_path: Path) -> None:
    shown = Terminal(fes("replay", str(logs / "run.mcap")), tmp_path, env=POSIX)
    shown.wait_for("q: quit")
    shown.type("q")
    assert shown.end() == 0
    assert is_restored(shown.text)
    assert "q: quit" in shown.left.rstrip("\n").split("\n")[-1]


def test_output_to_no_capable_terminal_has_no_escapes_even_with_forced_colors(tmp_path: Path) -> None:
    words = fes(*LOOP, "--duration", "0.2", "--out", "out")
    env = {**os.environ, "FORCE_COLOR": "1"}
    done = subprocess.run(words, cwd=tmp_path, env=env, capture_output=True, text=True, timeout=PATIENCE)
    assert done.returncode == 0
    assert ENTER not in done.stdout
    dumb = Terminal(fes(*LOOP, "--duration", "0.2", "--out", "dumb"), tmp_path, env={"TERM": "dumb"})
    assert dumb.end() == 0
    assert "\x1b" not in dumb.text
    assert "\nrun directory: dumb\n" in dumb.text


def test_a_reader_that_closes_before_the_last_frame_is_not_an_error() -> None:
    code = """
from console.dashboard import live as view
from console.terminal import printing
from fes.system import output
from tests.support.frames import a_report
output.configure()  # as every command does
with view.Screen(printing.console()) as shown:
    shown.show(a_report([(0.0, 0.0)]))
print("on", file=__import__("sys").stderr)
"""
    reader, writer = os.pipe()
    os.close(reader)
    try:
        done = subprocess.run(
            [sys.executable, "-c", code], cwd=ROOT, stdout=writer, stderr=subprocess.PIPE, text=True
        )
    finally:
        os.close(writer)
    assert (done.returncode, done.stderr) == (0, "on\n")
