"""A `fes run` that cannot start, or cannot write, prints one line at once, and leaves no partial files."""

import json
import resource
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support import hosts
from tests.support.paths import CONFIGS
from tests.support.processes import PATIENCE, STARTING, fes

PAIR = str(CONFIGS / "pair.toml")


@pytest.mark.skipif(bool(hosts.why_not()), reason=hosts.why_not() or "there are network namespaces")
def test_a_run_without_a_loopback_interface_fails_with_the_doctors_message(tmp_path: Path) -> None:
    words = ["unshare", "--net", *fes("run", PAIR, "--headless")]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE)
    remedy = "bring the loopback interface up: ip link set lo up"
    assert done.returncode == 1
    assert done.stderr == f"fes: error: loopback: 127.0.0.1: [Errno 101] Network is unreachable; {remedy}\n"
    assert not list(tmp_path.iterdir())


def test_certificates_without_their_extra_leave_no_run_directory(tmp_path: Path) -> None:
    code = "import sys; sys.modules['cryptography'] = None; from console.cli import main; main()"
    words = [sys.executable, "-c", code, "run", PAIR, "--secure"]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE)
    assert done.returncode == 1
    assert done.stderr.startswith(STARTING.format(2) + "fes: error: certificates need cryptography")
    assert not list(tmp_path.iterdir())


WRITE = """
import resource, sys
from pathlib import Path
from world.metrics import summary
from world.config.scenario import load
resource.setrlimit(resource.RLIMIT_FSIZE, (64, 64))
for write, what in ((summary.write, {"a": "b" * 100}), (summary.write_scenario, load(Path(sys.argv[1])))):
    try:
        write(Path("out"), what)
    except Exception as error:
        print(type(error).__name__, error)
"""
"""The system rejects more than 64 bytes per file, as on a full disk."""


def test_a_file_that_cannot_be_written_is_named_and_not_left_half_written(tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / "summary.json").write_text("{}")
    words = [sys.executable, "-c", WRITE, PAIR]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE)
    assert done.stdout.splitlines() == [
        f"FesError cannot write out/{name}: File too large" for name in ("summary.json", "scenario.toml")
    ]
    assert [path.name for path in out.iterdir()] == ["summary.json"]
    assert json.loads((out / "summary.json").read_text()) == {}


def test_a_scenario_that_cannot_be_written_leaves_no_run_directory(tmp_path: Path) -> None:
    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (64, 64))

    words = fes("run", PAIR, "--backend", "inprocess")
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, preexec_fn=limit, timeout=PATIENCE)
    assert done.returncode == 1
    assert done.stderr.endswith("fes: error: cannot write runs/pair-1/scenario.toml: File too large\n")
    assert not list(tmp_path.iterdir())


def test_a_removed_run_directory_takes_its_new_parents_with_it(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    code = "import sys; sys.modules['cryptography'] = None; from console.cli import main; main()"
    words = [sys.executable, "-c", code, "run", PAIR, "--secure", "--out", "a/b/c"]
    subprocess.run(words, cwd=tmp_path, capture_output=True, timeout=PATIENCE)
    assert [str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*")] == ["a"]
