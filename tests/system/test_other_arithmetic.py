"""Programs with another arithmetic: a resume, sweep or figure that would mix digits fails in one line."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from console.sweep import ledger
from fes.system import fingerprint
from tests.support import arithmetics
from tests.support.arithmetics import OTHER
from tests.support.commands import call, complaint
from tests.support.paths import CONFIGS, PAIR
from tests.support.teams import begun

PAPER = str(CONFIGS / "paper.toml")
HERE, THERE = fingerprint.text(), fingerprint.text(OTHER)


def test_programs_with_another_arithmetic_reject_resumed_runs_and_sweeps(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    words = ["sweep", PAIR, "--set", "run.duration=0.2", "--jobs", "1", "--out", "out"]
    begun(tmp_path / "run")
    recorded = call(tmp_path, "fes", "run", PAPER, "--duration", "1", "--backend", "inprocess", "--out", "log")
    with pytest.MonkeyPatch.context() as changed:
        for name, value in arithmetics.another(tmp_path).items():
            changed.setenv(name, value)
        first = call(tmp_path, "fes", *words, "--seeds", "0:1")
        resumed = call(tmp_path, "fes-world", "--resume", "run")
        again = call(tmp_path, "fes", "replay", "log", "--all")
    assert (recorded.returncode, first.returncode) == (0, 0)
    there = json.loads((tmp_path / "out" / ledger.HEADER).read_text())["arithmetic"]
    assert there != HERE
    before = (tmp_path / "out" / ledger.LINES).read_bytes()
    line = complaint(call(tmp_path, "fes", *words, "--seeds", "0:2"), "fes")
    assert line.endswith(f'sweep.json has arithmetic = "{there}", and this is {HERE}')
    assert (tmp_path / "out" / ledger.LINES).read_bytes() == before
    assert complaint(resumed, "fes-world").endswith(
        f"was written with {HERE}; this is {there}: the digits would differ"
    )
    # The switch decides if a second of ten robots has other digits; the next line is the same.
    if again.returncode == 0:
        assert again.stderr == ""
    else:
        assert again.stderr.splitlines()[1:] == [f"fes: recorded with {HERE}; executed with {there}"]


def test_figures_of_a_run_with_another_arithmetic_name_both(tmp_path: Path) -> None:
    run = tmp_path / "run"
    done = call(
        tmp_path, "fes", "run", PAIR, "--duration", "0.2", "--backend", "inprocess", "--no-record", "--out", "run"
    )
    assert done.returncode == 0
    summary = json.loads((run / "summary.json").read_text())
    (run / "summary.json").write_text(json.dumps({**summary, "digest": "0" * 64, "arithmetic": OTHER}))
    line = complaint(call(tmp_path, "fes", "plot", "run"), "fes")
    assert line.endswith(f"cannot be executed again bit for bit here: it was made with {THERE}; this is {HERE}")
    shutil.rmtree(run)


def test_the_fingerprint_is_the_same_in_every_process_of_one_machine() -> None:
    for environment in ({"OPENBLAS_NUM_THREADS": "1", "PYTHONHASHSEED": "1"}, {"OPENBLAS_NUM_THREADS": "4"}):
        assert arithmetics.of(environment) == HERE
    assert f"numpy {np.__version__}, arithmetic {fingerprint.table()['fingerprint']}" == HERE
