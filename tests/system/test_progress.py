"""A command that takes longer than a second shows its progress on a terminal only."""

import io
import re
import subprocess
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path

import pytest
from rich.console import Console

from console.sweep import design, local, work
from console.sweep.work import Batch
from console.terminal import progress
from console.terminal.screen import ERASE
from fes import process
from fes.system import signals
from tests.support import recordings
from tests.support.loop import load
from tests.support.paths import PAIR
from tests.support.processes import PATIENCE, fes
from tests.support.terminals import HIDE, Terminal, is_restored

LONG = ["--set", "run.duration=60", "--jobs", "1", "--out", "out"]


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The log of two robots over four seconds."""
    path = tmp_path_factory.mktemp("progress") / "run.mcap"
    recordings.record(path, load("pair.toml", run__duration=4.0))
    return path


def batch_of(runs: int, seconds: float) -> Batch:
    planned = design.plan(Path(PAIR), [], f"0:{runs}", [f"run.duration={seconds}"])
    (batch,) = work.batches("pair", planned.runs, 1)
    return batch


def test_a_batch_reports_each_tick_of_all_its_runs() -> None:
    reports: list[int] = []
    done = work.carry_out(batch_of(3, 0.2), reports.append)
    assert [outcome.error for outcome in done] == [None] * 3
    assert reports == [3 * tick for tick in range(1, 11)]


def test_workers_report_ticks_before_their_batch_has_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(local, "PERIOD", 0.001)
    reports: list[int] = []
    batch = batch_of(2, 20.0)
    with local.hired(1) as workers:
        (done,) = workers.carry_out([batch], reports.append)
    assert len(done) == 2
    assert reports == sorted(reports)
    assert reports[-1] == 2000
    assert any(0 < ticks < 2000 for ticks in reports)


def test_the_progress_bar_of_a_sweep_moves_within_one_batch(tmp_path: Path) -> None:
    shown = Terminal(fes("sweep", PAIR, "--seeds", "0:3", *LONG), tmp_path, 100)
    assert shown.end() == 0, shown.text
    within = {int(part) for part in re.findall(r"(\d+)%[^%]*?0/3 runs", shown.text)}
    assert within & set(range(1, 100))
    assert is_restored(shown.text)


@pytest.mark.parametrize(
    "words",
    [
        ["run", PAIR, "--backend", "inprocess", "--headless", "--duration", "4"],
        ["replay", "LOG", "--all"],
        ["compare", "LOG", "LOG"],
        ["claims", "weights"],
    ],
    ids=" ".join,
)
def test_a_long_command_shows_a_bar_on_a_terminal_and_nothing_in_a_pipe(
    words: list[str], recorded: Path, tmp_path: Path
) -> None:
    command = fes(*(word.replace("LOG", str(recorded)) for word in words))
    with (tmp_path / "out").open("w") as out:
        shown = Terminal(command, tmp_path, env={"PYTHONIOENCODING": "ascii"}, stdout=out.fileno())
        assert shown.end() == 0, shown.text
    assert HIDE in shown.text
    assert ":00:0" in shown.text
    assert is_restored(shown.text)
    if words[0] == "claims":  # tests of the other commands check their standard error
        piped = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE)
        assert (piped.returncode, piped.stderr) == (0, "")
        assert piped.stdout == (tmp_path / "out").read_text()


def test_a_replay_runs_on_a_terminal_whose_input_is_closed(recorded: Path, tmp_path: Path) -> None:
    words = ["sh", "-c", 'exec "$@" <&-', "sh", *fes("replay", str(recorded))]
    shown = Terminal(words, tmp_path)
    assert shown.end() == 0, shown.text
    assert "the world, executed again: 200 ticks, the same to the bit" in shown.text


def test_progress_names_the_figure_that_is_drawn(recorded: Path, tmp_path: Path) -> None:
    shown = Terminal(fes("plot", str(recorded), "--out", "drawn"), tmp_path, 120)
    assert shown.end() == 0, shown.text
    assert "the run again" in shown.text
    assert shown.text.rstrip().endswith("drawn/convergence.svg")


class Screen(io.StringIO):
    """A terminal that keeps its output."""

    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize("kind", ["bar", "waiting", "status"])
def test_warnings_beside_a_line_of_progress_stay_on_standard_error_unwrapped(
    kind: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    console = Console(file=Screen(), force_terminal=True, width=40)
    monkeypatch.setattr("console.terminal.printing.console", lambda stderr=False: console)
    line, data = "a warning " + "x" * 300, "data " + "y" * 300
    shown: dict[str, Callable[[], AbstractContextManager[object]]] = {
        "bar": lambda: progress.bar("counting"),
        "waiting": lambda: progress.waiting("counting"),
        "status": lambda: progress.status(console, "counting"),
    }
    with signals.restored(), shown[kind]():
        process.warn("fes", line)
        print(data)
    out, err = capsys.readouterr()
    assert (out, err) == (f"{data}\n", f"fes: warning: {line}\n")
    assert isinstance(console.file, Screen)
    text = console.file.getvalue()
    assert "counting" in text
    assert ERASE in text
    assert "warning" not in text
