"""A command that takes longer than a second shows its progress on a terminal only."""

import re
import signal
import subprocess
from pathlib import Path

import pytest

from console.replay import command as replay_command
from console.replay import log
from console.sweep import design, local, work
from console.sweep.work import Batch
from fes.system import strict_json
from tests.support import recordings
from tests.support.loop import load
from tests.support.paths import PAIR
from tests.support.processes import PATIENCE, fes
from tests.support.terminals import HIDE, Terminal, is_restored

LONG = ["--set", "run.duration=60", "--jobs", "1", "--out", "out"]


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The log of two robots over eight seconds."""
    path = tmp_path_factory.mktemp("progress") / "run.mcap"
    recordings.record(path, load("pair.toml", run__duration=8.0))
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


@pytest.mark.parametrize("jobs", ["1", "2"])
def test_the_progress_bar_of_a_sweep_moves_within_one_batch(jobs: str, tmp_path: Path) -> None:
    """No run has ended, and the bar moves: it counts ticks, with their rate and the time that is left."""
    words = ["--set", "run.duration=60", "--jobs", jobs, "--out", "out"]
    shown = Terminal(fes("sweep", PAIR, "--seeds", "0:4", *words), tmp_path, 100)
    assert shown.end() == 0, shown.text
    within = {int(part) for part in re.findall(r"(\d+)%[^%]*?0/4 runs", shown.text)}
    assert within & set(range(1, 100))
    assert re.search(r"\dk? ticks/s", shown.text)
    assert re.search(r"\d:\d\d:\d\d.* left", shown.text)
    assert is_restored(shown.text)


@pytest.mark.parametrize("words", [["--all"], ["--robot", "1"], ["--all", "--json"]], ids=" ".join)
def test_the_progress_bar_of_a_replay_moves_in_ticks(words: list[str], recorded: Path, tmp_path: Path) -> None:
    with (tmp_path / "out").open("w") as out:
        shown = Terminal(fes("replay", str(recorded), *words), tmp_path, 100, stdout=out.fileno())
        assert shown.end() == 0, shown.text
    assert re.search(r"\d+%", shown.text)  # a fast processor ends between two updates of the bar
    assert "ticks/s" in shown.text
    assert is_restored(shown.text)
    result = (tmp_path / "out").read_text()
    assert "\x1b" not in result
    if "--json" in words:
        assert strict_json.loads(result)["ticks"] == 400


def test_a_replay_of_a_robot_counts_each_tick(recorded: Path) -> None:
    counted: list[int] = []
    replay_command.rerun_robot(log.load(recorded), 1, counted.append)
    assert counted == list(range(1, 401))


def test_an_interrupted_bar_leaves_a_line_without_a_bar_and_a_cursor(tmp_path: Path) -> None:
    shown = Terminal(fes("sweep", PAIR, "--seeds", "0:40", *LONG), tmp_path, 100)
    shown.wait_for("ticks/s")
    shown.send(signal.SIGINT)
    assert shown.end() != 0
    assert is_restored(shown.text)
    assert "\x1b[2K" in shown.text  # the bar is erased before the last line
    assert shown.text.rpartition("\x1b[2K")[2].count("%") == 0
    assert "the same command resumes the sweep" in shown.text


def test_a_sweep_in_a_pipe_prints_no_codes_of_a_terminal(tmp_path: Path) -> None:
    words = fes("sweep", PAIR, "--seeds", "0:2", "--set", "run.duration=1", "--jobs", "2", "--out", "out")
    piped = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE)
    assert (piped.returncode, piped.stderr) == (0, "")
    assert "\x1b" not in piped.stdout


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
    assert re.search(r"[\d-]:[\d-]{2}:[\d-]{2}", shown.text)
    assert is_restored(shown.text)
    if words[0] == "claims":  # tests of the other commands check their standard error
        piped = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE)
        assert (piped.returncode, piped.stderr) == (0, "")
        assert piped.stdout == (tmp_path / "out").read_text()


def test_a_replay_runs_on_a_terminal_whose_input_is_closed(recorded: Path, tmp_path: Path) -> None:
    words = ["sh", "-c", 'exec "$@" <&-', "sh", *fes("replay", str(recorded))]
    shown = Terminal(words, tmp_path)
    assert shown.end() == 0, shown.text
    assert "the world, executed again: 400 ticks, the same to the bit" in shown.text


def test_progress_names_the_figure_that_is_drawn(recorded: Path, tmp_path: Path) -> None:
    shown = Terminal(fes("plot", str(recorded), "--out", "drawn"), tmp_path, 120)
    assert shown.end() == 0, shown.text
    assert "the run again" in shown.text
    assert shown.text.rstrip().endswith("drawn/convergence.svg")
