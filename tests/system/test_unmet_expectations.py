"""A run that does not meet its expectations: exit code 2, and the observed values."""

import json
import subprocess
from pathlib import Path

import pytest

from tests.support.paths import CONFIGS
from tests.support.processes import LOOP, PATIENCE, STARTING, fes


@pytest.mark.parametrize("backend", ["inprocess", "processes"])
def test_a_run_with_unmet_expectations_exits_with_2_and_shows_the_values(backend: str, tmp_path: Path) -> None:
    words = ["run", str(CONFIGS / "pair.toml"), "--duration", "1", "--headless", "--backend", backend]
    objective = 'expect=[{of="ticks", equals=50}, {of="estimate_error_max", below=1e-9}]'
    done = subprocess.run(
        fes(*words, "--set", objective), cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE
    )
    assert (done.returncode, done.stderr) == (2, (LOOP if backend == "inprocess" else STARTING).format(2))
    lines = done.stdout.splitlines()
    assert any("ticks" in line and "equal to 50" in line and "holds" in line for line in lines)
    assert any("estimate_error_max" in line and "does not hold" in line for line in lines)
    kept = json.loads((tmp_path / "runs/latest/summary.json").read_text())
    assert [verdict["holds"] for verdict in kept["expectations"]] == [True, False]
