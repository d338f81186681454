"""Remarks of commands on settings that they do not use as written."""

import json
import subprocess
from pathlib import Path

from tests.support.paths import CONFIGS
from tests.support.processes import LOOP, PATIENCE, STARTING, fes


def test_fes_run_prints_remarks_with_both_backends_and_fes_world_logs_them(tmp_path: Path) -> None:
    words = [str(CONFIGS / "pair.toml"), "--duration", "0.05", "--set", "event=[{at = 9.0, kill = [0]}]"]
    said = [
        "run.duration 0.05 s is not a multiple of run.dt 0.02 s: 2 ticks are run, 0.04 s",
        "event at 9 s is not before the end of the run at 0.04 s: it never acts",
    ]
    for backend, first in (("inprocess", LOOP), ("processes", STARTING)):
        call = fes("run", *words, "--backend", backend, "--json", "--out", backend)
        done = subprocess.run(call, cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE)
        assert done.returncode == 0
        assert done.stderr == first.format(2) + "".join(f"fes: warning: {line}\n" for line in said)
        assert json.loads(done.stdout)["ticks"] == 2
    logged = (tmp_path / "processes" / "world.log").read_text().splitlines()
    assert [line.partition(" world: ")[2] for line in logged[:2]] == said


def test_fes_sweep_prints_remarks_once_for_all_cells(tmp_path: Path) -> None:
    words = ["--seeds", "0:3", "--set", "run.duration=0.05", "--axis", "formation.rule=disk,two_nearest"]
    call = fes("sweep", str(CONFIGS / "pair.toml"), *words, "--out", "/dev/null")  # it can do no more there
    done = subprocess.run(call, cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE)
    assert done.returncode == 1
    line = "fes: warning: run.duration 0.05 s is not a multiple of run.dt 0.02 s: 2 ticks are run, 0.04 s\n"
    assert done.stderr.startswith(line)
    assert done.stderr.count("\n") == 2
