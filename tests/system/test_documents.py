"""The blocks of the pages that are marked <!-- run -->: a reader's commands and Python, in a reader's order."""

import os
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support import fences
from tests.support.paths import CONFIGS, ROOT
from tests.support.processes import PATIENCE

SHORT = """
case "${1-}" in
    run) set -- "$@" --set run.duration=0.6 --agents-per-process 5 ;;
    sweep) set -- "$@" --set run.duration=0.6 ;;
esac
"""
"""Cheaper runs: a shorter simulated time [s], unless the flag --duration sets another, and fewer processes."""

PROGRAMS = {
    "fes": "console.cli", "fes-world": "world.process", "fes-agent": "agents.process",
    "fes-robot": "field.__main__", "fes-tabletop": "world.tabletop.__main__",
}  # fmt: skip
RUN = [page for page in fences.PAGES if any(block.mark == fences.RUN for block in fences.shell(page))]
PYTHON = [page for page in fences.PAGES if any(block.mark == fences.RUN for block in fences.python(page))]


@pytest.fixture
def environment(tmp_path: Path) -> dict[str, str]:
    """The commands under test first on the path, with short runs."""
    programs = tmp_path / "bin"
    programs.mkdir()
    for name, module in PROGRAMS.items():
        start = f"exec {shlex.quote(sys.executable)} -c 'from {module} import main; main()'"
        short = SHORT if name == "fes" else ""
        (programs / name).write_text(f'#!/bin/sh\n{short}{start} "$@"\n', encoding="utf-8")
        (programs / name).chmod(0o755)
    return {
        **os.environ,
        "PATH": f"{programs}{os.pathsep}{os.environ['PATH']}",
        "PYTHONPATH": str(ROOT),
        "OPENBLAS_NUM_THREADS": "1",
    }


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A reader's folder, with the configurations of a clone."""
    folder = tmp_path / "folder"
    folder.mkdir()
    (folder / "configs").symlink_to(CONFIGS)
    return folder


@pytest.mark.slow
@pytest.mark.parametrize("page", RUN, ids=lambda path: path.stem)
def test_the_commands_of_a_page_work_in_its_order(page: Path, folder: Path, environment: dict[str, str]) -> None:
    for block in fences.blocks(page):
        if file := fences.FILE.fullmatch(block.mark):
            (folder / file[1]).write_text(block.text, encoding="utf-8")
        if block.language != "sh" or block.mark != fences.RUN:
            continue
        done = subprocess.run(
            ["bash", "-euo", "pipefail", "-c", block.text],
            cwd=folder,
            env=environment,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=4 * PATIENCE,
        )
        assert done.returncode == 0, f"{page.name}, line {block.line}: {done.stderr}"


@pytest.mark.slow
@pytest.mark.parametrize("page", PYTHON, ids=lambda path: path.stem)
def test_the_python_of_a_page_works_in_its_order(page: Path, folder: Path, environment: dict[str, str]) -> None:
    # Each block begins at its line of the page, which a traceback then names.
    text = ""
    for block in fences.python(page):
        if block.mark == fences.RUN:
            text += "\n" * (block.line - text.count("\n")) + block.text
    (folder / f"{page.stem}.py").write_text(text, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-W", "error", f"{page.stem}.py"],
        cwd=folder,
        env=environment,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=4 * PATIENCE,
    )
    assert (done.returncode, done.stderr) == (0, ""), page.name


def test_the_tutorial_and_the_pages_on_python_are_run() -> None:
    assert {"first-run", "own-law"} <= {page.stem for page in RUN}
    assert {"README", "python"} <= {page.stem for page in PYTHON}
