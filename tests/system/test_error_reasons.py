"""Reasons of errors: the system's text, or our own where it has none."""

import ast
import subprocess
from pathlib import Path

from fes.system.distribution import PACKAGES
from tests.support.commands import PROGRAMS, call, complaint
from tests.support.paths import CONFIGS, ROOT

IN = ["--backend", "inprocess", "--headless", "--json", "--duration", "0.2"]


def test_only_one_function_reads_the_text_of_an_error() -> None:
    for package in (*PACKAGES, "bench"):
        for path in (ROOT / package).rglob("*.py"):
            tree = ast.parse(path.read_text(encoding="utf-8"))
            asked = [
                node.lineno for node in ast.walk(tree) if isinstance(node, ast.Attribute) and node.attr == "strerror"
            ]
            assert asked == [] or path == ROOT / "fes" / "errors.py", f"{path}: lines {asked}"


def test_a_log_from_a_pipe_is_rejected_with_a_reason(tmp_path: Path) -> None:
    assert call(tmp_path, "fes", "run", str(CONFIGS / "pair.toml"), *IN, "--out", "run").returncode == 0
    for words in ("replay LOG", "compare LOG run", "compare run LOG", "plot LOG"):
        script = f"{PROGRAMS}/fes {words.replace('LOG', '<(cat run/run.mcap)')}"
        done = subprocess.run(["bash", "-c", script], cwd=tmp_path, capture_output=True, text=True, timeout=60)
        line = complaint(done, "fes")
        assert line.startswith("/dev/fd/")
        assert line.endswith(": is not a regular file")


def test_a_scenario_from_a_pipe_is_accepted(tmp_path: Path) -> None:
    script = f"{PROGRAMS}/fes run <(cat {CONFIGS / 'pair.toml'}) {' '.join(IN)}"
    done = subprocess.run(["bash", "-c", script], cwd=tmp_path, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
