"""The command fes sweep: called, stopped, killed and called again."""

import csv
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from pyarrow import parquet

from console.analysis import figures
from console.backends import inprocess
from console.sweep import cluster, table, work
from console.sweep.table import Format
from fes.errors import FesError
from fes.system.distribution import install
from tests.support.commands import PROGRAMS, call, complaint, vacant
from tests.support.loop import load
from tests.support.paths import PAIR
from tests.support.processes import PATIENCE
from tests.support.sweeps import LONG, RUNS, finished, until_some_are_done

RULES = ["--axis", "formation.rule=disk,two_nearest"]

WITNESS = """
import functools, os
from console.sweep import work

carry_out = work.carry_out

@functools.wraps(carry_out)
def witnessed(batch, *watch):
    with open(os.environ["WITNESS"], "a") as file:
        file.write("".join(f"{os.getpid()} {key}\\n" for key in batch.keys))
    return carry_out(batch, *watch)

work.carry_out = witnessed
"""
"""Loaded by every Python that starts in the test: workers log the runs that they begin."""


def start(where: Path, log: str) -> "subprocess.Popen[str]":
    """The long sweep, with recorded workers."""
    (where / "sitecustomize.py").write_text(WITNESS)
    path = os.pathsep.join(filter(None, (str(where), os.environ.get("PYTHONPATH"))))
    return subprocess.Popen(
        [str(PROGRAMS / "fes"), *LONG],
        cwd=where,
        env={**os.environ, "PYTHONPATH": path, "WITNESS": str(where / log)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )


def begun(log: Path) -> list[tuple[int, str]]:
    """Process and key of every run that a worker began."""
    pairs = [line.split() for line in log.read_text().splitlines()]
    return [(int(process), key) for process, key in pairs]


def gone(process: int) -> bool:
    """True if a process has ended, even if no parent has collected it yet."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] == "Z"
    except OSError:
        return True


def assert_all_gone(processes: set[int]) -> None:
    assert processes
    patience = time.monotonic() + PATIENCE
    while not all(map(gone, processes)):
        assert time.monotonic() < patience, "a worker outlived its sweep"
        time.sleep(0.02)


def test_a_row_equals_the_summary_of_a_single_run_and_is_not_computed_twice(tmp_path: Path) -> None:
    words = ["fes", "sweep", PAIR, "--seeds", "4,2", *RULES, "--set", "run.duration=2", "--plot"]
    done = call(tmp_path, *words)
    assert (done.returncode, done.stderr) == (0, "")
    (directory,) = (tmp_path / "sweeps").iterdir()
    with (directory / "table.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [(row["formation.rule"], row["seed"]) for row in rows] == [
        ("disk", "4"),
        ("disk", "2"),
        ("two_nearest", "4"),
        ("two_nearest", "2"),
    ]
    alone = inprocess.run(load("pair.toml", run__duration=2.0, run__seed=2, formation__rule="two_nearest"), "pair")
    assert (rows[3]["digest"], rows[3]["beacons_decoded"]) == (alone["digest"], str(alone["beacons_decoded"]))
    assert rows[3]["time_to.separation_0_1m"] == ""  # not reached: two seconds are not enough
    assert not work.WALL_CLOCK & rows[0].keys()
    # Two robots are each other's nearest, so both rules have the same radio: no digit differs.
    assert [row["digest"] for row in rows[:2]] == [row["digest"] for row in rows[2:]]
    with (directory / "differences.csv").open(newline="") as file:
        assert {row["mean"] for row in csv.DictReader(file) if row["pairs"] == "2"} == {"0.0"}
    assert (directory / "sweep.png").read_bytes().startswith(b"\x89PNG")

    before = {path: path.read_bytes() for path in directory.iterdir()}
    again = call(tmp_path, *words)
    assert (again.returncode, again.stdout) == (0, done.stdout)
    assert {path: path.read_bytes() for path in directory.iterdir()} == before


def test_parquet_holds_what_csv_holds_with_its_types(tmp_path: Path) -> None:
    words = ["fes", "sweep", PAIR, "--seeds", "0:3", *RULES, "--set", "run.duration=1", "--out", "out"]
    for form in ("csv", "parquet"):
        assert call(tmp_path, *words, "--format", form).returncode == 0
    typed = parquet.read_table(tmp_path / "out" / "table.parquet")
    names = ("seed", "disagreement", "digest", "disk_connected_always")
    assert [str(typed.schema.field(name).type) for name in names] == ["int64", "double", "string", "bool"]
    again: list[table.Row] = typed.to_pylist()
    table.write(tmp_path, "again", again)
    assert (tmp_path / "again.csv").read_bytes() == (tmp_path / "out" / "table.csv").read_bytes()


def test_a_killed_sweep_resumes_and_repeats_no_finished_run(tmp_path: Path) -> None:
    killed = start(tmp_path, "first")
    until_some_are_done(tmp_path / "out", killed)
    killed.kill()
    killed.communicate()
    assert_all_gone({process for process, _ in begun(tmp_path / "first")})
    done = finished(tmp_path / "out")
    assert 0 < len(done) < RUNS

    resumed = start(tmp_path, "second")
    output, complained = resumed.communicate(timeout=PATIENCE)
    assert (resumed.returncode, complained) == (0, "")
    assert "out/table.csv" in output
    executed = [key for _, key in begun(tmp_path / "second")]
    assert not set(executed) & set(done)
    assert sorted(executed + done) == sorted(finished(tmp_path / "out"))
    assert len(set(finished(tmp_path / "out"))) == len(finished(tmp_path / "out")) == RUNS

    at_once = call(tmp_path, "fes", *LONG[:-1], "at-once", "--jobs", "1")
    assert at_once.returncode == 0
    assert (tmp_path / "at-once" / "table.csv").read_bytes() == (tmp_path / "out" / "table.csv").read_bytes()


def test_an_interrupted_sweep_reports_its_progress_and_leaves_no_process(tmp_path: Path) -> None:
    sweep = start(tmp_path, "log")
    until_some_are_done(tmp_path / "out", sweep)
    os.killpg(sweep.pid, signal.SIGINT)  # like a terminal: the sweep and its workers
    output, complained = sweep.communicate(timeout=PATIENCE)
    done = len(finished(tmp_path / "out"))
    assert (sweep.returncode, output) == (1, "")
    assert complained == (
        f"fes: error: stopped by SIGINT: {done} of {RUNS} runs are done; the same command resumes the sweep\n"
    )
    assert_all_gone({process for process, _ in begun(tmp_path / "log")})


def test_a_failed_run_is_in_the_table_with_its_reason_and_the_others_are_there(tmp_path: Path) -> None:
    gains = ["--axis", "seeking.index_gain=4e4,1e308", "--set", "run.duration=1", "--out", "out"]
    done = call(tmp_path, "fes", "sweep", PAIR, "--seeds", "0:2", *gains)
    assert done.returncode == 1
    assert done.stderr.startswith("fes: error: 2 of 4 runs failed; the first is 1e+308, seed 0: robot ")
    assert done.stderr.count("\n") == 1
    with (tmp_path / "out" / "table.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [bool(row["digest"]) for row in rows] == [True, True, False, False]
    assert ["not finite" in row["error"] for row in rows] == [False, False, True, True]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ([], ["--seeds"]),
        (["--seeds", "0:0"], ["--seeds", "'0:0'"]),
        (["--seeds", "0:2", "--axis", "formation.rul=disk"], ["'formation.rul'", "'formation.rule'"]),
        (["--seeds", "0:2", "--axis", "formation.rule=ring"], ["formation.rule", "'ring'"]),
        (["--seeds", "0:2", "--jobs", "0"], ["--jobs", "1"]),
        (["--seeds", "0:2", "--format", "xls"], ["--format", "'xls'"]),
        (["--seeds", "0:2", "--scheduler", "nowhere"], ["--scheduler", "tcp://", "'nowhere'"]),
        (["--seeds", "0:2", "--scheduler", "tcp://127.0.0.1:1", "--jobs", "2"], ["--jobs", "--scheduler"]),
    ],
)
def test_bad_input_is_reported_in_one_line_and_leaves_nothing(
    words: list[str], said: list[str], tmp_path: Path
) -> None:
    line = complaint(call(tmp_path, "fes", "sweep", PAIR, *words), "fes")
    assert [word for word in said if word not in line] == []
    assert list(tmp_path.iterdir()) == []


def test_a_missing_extra_is_named_before_anything_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    for module in (table, figures):
        monkeypatch.setattr(module, "find_spec", lambda name: None)
    with pytest.raises(FesError, match=re.escape(install("parquet"))):
        table.require(Format.PARQUET)
    with pytest.raises(FesError, match=re.escape(install("plot"))):
        figures.require()
    monkeypatch.setitem(sys.modules, "distributed", None)
    address = vacant().replace("tcp/", "tcp://")
    with pytest.raises(FesError, match=re.escape(install("cluster"))), cluster.connected(address):
        pass


def test_a_column_without_values_is_numeric_in_parquet(tmp_path: Path) -> None:
    paths = [
        table.write(tmp_path, name, [{"time": time, "digest": None, "error": None}], Format.PARQUET)
        for name, time in (("never", None), ("reached", 1.5))
    ]
    never, reached = map(parquet.read_table, paths)
    assert [str(field.type) for field in never.schema] == ["double", "string", "string"]
    assert never.schema == reached.schema


def test_a_sweep_whose_runs_all_failed_draws_no_figure_and_names_the_command_that_repeats_them(
    tmp_path: Path,
) -> None:
    words = ["sweep", PAIR, "--seeds", "0:2", "--set", "seeking.index_gain=1e308", "--set", "run.duration=1"]
    done = call(tmp_path, "fes", *words, "--out", "out", "--plot")
    assert done.returncode == 1
    assert done.stderr.startswith("fes: error: 2 of 2 runs failed; the first is ")
    assert done.stderr.endswith("to repeat them, delete the lines with an error in out/runs.jsonl\n")
    assert done.stderr.count("\n") == 1
    assert not (tmp_path / "out" / "sweep.png").exists()


def test_the_table_writes_what_csv_cannot_show_as_an_empty_field(tmp_path: Path) -> None:
    path = table.write(tmp_path, "x", [{"a": None, "b": True, "c": 0.1 + 0.2, "d": 'say "no", twice'}])
    assert path.read_text() == 'a,b,c,d\n,true,0.30000000000000004,"say ""no"", twice"\n'
