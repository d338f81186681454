"""The notebooks of the examples, executed as they are stored."""

import json
import math
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.paths import ROOT

FOLDER = ROOT / "examples" / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))
EXECUTE = """
import sys
import nbformat
from nbclient import NotebookClient
notebook = nbformat.read(sys.argv[1], 4)
NotebookClient(notebook, kernel_name="python3", timeout=140).execute()
nbformat.write(notebook, sys.argv[2])
"""

TIMES = re.compile(r"^paper, saturated: \[(.*)\] s$", re.MULTILINE)
"""The line with the mean times of both laws [s]."""


def printed(notebook: Path) -> str:
    """All that the cells of an executed notebook printed."""
    cells = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
    outputs = [output for cell in cells for output in cell.get("outputs", ())]
    return "".join("".join(output["text"]) for output in outputs if output["output_type"] == "stream")


def test_there_are_three_notebooks_and_the_page_of_examples_names_each() -> None:
    page = (ROOT / "examples" / "README.md").read_text(encoding="utf-8")
    assert [path.stem for path in NOTEBOOKS] == ["first-run", "own-law", "reading-a-log"]
    assert all(f"notebooks/{path.name}" in page for path in NOTEBOOKS)


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_is_stored_without_output_and_runs_to_its_end(
    tmp_path: Path, path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    assert not any(cell.get("outputs") or cell.get("execution_count") for cell in cells)
    for name in ("JUPYTER_RUNTIME_DIR", "JUPYTER_CONFIG_DIR", "IPYTHONDIR", "MPLCONFIGDIR", "TMPDIR"):
        (tmp_path / name).mkdir()
        monkeypatch.setenv(name, str(tmp_path / name))
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    words = [sys.executable, "-c", EXECUTE, str(path), "executed.ipynb"]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-2000:]
    if path.stem == "own-law":
        times = TIMES.search(printed(tmp_path / "executed.ipynb"))
        assert times is not None
        paper, saturated = map(float, times[1].split())
        assert math.isfinite(paper)
        assert paper < saturated < math.inf  # the notebook says that its law loses
