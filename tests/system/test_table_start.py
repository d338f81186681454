"""fes team run whose table does not start: one line says why, without the wait for a table that never listens."""

import os
import subprocess
from pathlib import Path

from tests.support.processes import PATIENCE, fes


def test_a_team_whose_table_does_not_start_ends_with_the_reason_of_the_table(tmp_path: Path) -> None:
    hidden = tmp_path / "hidden"
    hidden.mkdir()
    (hidden / "mujoco.py").write_text("raise ImportError\n", encoding="utf-8")
    paths = [str(hidden), *filter(None, [os.environ.get("PYTHONPATH")])]
    done = subprocess.run(
        fes("team", "run", "tabletop", "--body", "mujoco", "--duration", "1"),
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)},
        capture_output=True,
        text=True,
        timeout=PATIENCE,
    )
    assert done.returncode == 1
    [line] = [line for line in done.stderr.splitlines() if "error" in line]
    assert line.startswith("fes: error: fes-tabletop: bodies in MuJoCo need the extra 'mujoco'")
