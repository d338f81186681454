"""Unreadable logs: each command reports them in one line."""

import subprocess
from pathlib import Path

from tests.support.processes import PATIENCE, command


def test_a_program_reports_a_broken_log_in_one_line_and_returns_1(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("hello\n")
    for words in (["replay", "notes.txt"], ["compare", "notes.txt", "notes.txt"], ["plot", "notes.txt"]):
        done = subprocess.run(
            command("console.cli", *words), cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE
        )
        assert (done.returncode, done.stdout) == (1, "")
        assert done.stderr == "fes: error: notes.txt is not a log: it is not an MCAP file\n"
