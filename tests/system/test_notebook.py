"""The Python interface in a real Jupyter kernel: its output, and the interrupt of its user."""

import json
import os
import queue
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from jupyter_client.blocking.client import BlockingKernelClient
from jupyter_client.manager import KernelManager

import fes
from tests.support.paths import ROOT
from tests.support.processes import PATIENCE

CELLS = [
    "import fes, asyncio; asyncio.get_running_loop().is_running()",
    'run = fes.run("paper", seed=4, duration=1.0, rtf=3.0)\nprint(run.digest)',
    "run",
    "run.frame().shape, len(run.links.frame()) == len(run.links)",
    'processes = fes.run("paper", seed=4, duration=1.0, backend="processes", agents_per_process=5)\n'
    "processes.digest == run.digest",
    'table = fes.sweep("pair", seeds=range(2), overrides={"run.duration": 0.2}, jobs=1)\nlen(table.frame())',
]

EXECUTE = """
import nbformat
from nbclient import NotebookClient
notebook = nbformat.read("notebook.ipynb", 4)
NotebookClient(notebook, kernel_name="python3").execute()
nbformat.write(notebook, "executed.ipynb")
"""

ENDLESS = {
    "in one loop": 'fes.run("pair", duration=1e5, progress=show)',
    "in processes": 'fes.run("pair", duration=1e5, backend="processes", progress=show)',
}
SHOW = """
import fes
def show(done, total):
    if done and not shown:
        shown.append(print("running", flush=True))
shown = []
"""
LEFT = """
import threading
from pathlib import Path
children = [path.read_text().split() for path in Path("/proc/self/task").glob("*/children")]
print(sum(map(len, children)), "fes" in [thread.name for thread in threading.enumerate()])
"""


@pytest.fixture
def environment(tmp_path: Path) -> dict[str, str]:
    """The environment of a kernel, which keeps all of its files in the folder of the test."""
    folders = {name: str(tmp_path / name) for name in ("JUPYTER_RUNTIME_DIR", "JUPYTER_CONFIG_DIR", "IPYTHONDIR")}
    return {**os.environ, **folders, "PYTHONPATH": str(ROOT), "HOME": str(tmp_path), "TMPDIR": str(tmp_path)}


@pytest.fixture
def kernel(tmp_path: Path, environment: dict[str, str]) -> Iterator[tuple[KernelManager, BlockingKernelClient]]:
    manager = KernelManager()
    manager.start_kernel(cwd=str(tmp_path), env=environment)
    client = manager.client()
    client.start_channels()
    try:
        client.wait_for_ready(timeout=PATIENCE)
        yield manager, client
    finally:
        client.stop_channels()
        manager.shutdown_kernel(now=True)


def outputs(client: BlockingKernelClient, request: str) -> Iterator[dict[str, Any]]:
    """The messages that a cell sends, up to its end."""
    end = time.monotonic() + PATIENCE
    while True:
        try:
            message = client.get_iopub_msg(timeout=end - time.monotonic())
        except queue.Empty:
            raise AssertionError("the cell has not ended") from None
        if message["parent_header"].get("msg_id") != request:
            continue
        if message["content"] == {"execution_state": "idle"}:
            return
        yield message


def test_a_notebook_runs_shows_and_sweeps(tmp_path: Path, environment: dict[str, str]) -> None:
    code: dict[str, object] = {"cell_type": "code", "metadata": {}, "outputs": [], "execution_count": None}
    cells = [{**code, "id": f"{index}", "source": cell} for index, cell in enumerate(CELLS)]
    notebook = {"cells": cells, "metadata": {}, "nbformat": 4, "nbformat_minor": 5}
    (tmp_path / "notebook.ipynb").write_text(json.dumps(notebook))
    done = subprocess.run(
        [sys.executable, "-c", EXECUTE],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        timeout=2 * PATIENCE,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    executed = [cell["outputs"] for cell in json.loads((tmp_path / "executed.ipynb").read_text())["cells"]]
    digest = fes.run("paper", seed=4, duration=1.0).digest
    results = [
        ["".join(output["data"]["text/plain"]) for output in cell if output["output_type"] == "execute_result"]
        for cell in executed
    ]
    assert results[0] == ["True"]  # a loop runs in the kernel
    assert [output["text"] for output in executed[1] if output["output_type"] == "stream"] == [[f"{digest}\n"]]
    assert results[2][0].startswith("Run(paper, seed 4: 10 robots, 50 ticks")
    assert results[3:] == [["((500, 8), True)"], ["True"], ["2"]]


def test_a_notebook_shows_a_bar_without_widgets(kernel: tuple[KernelManager, BlockingKernelClient]) -> None:
    _, client = kernel
    request = client.execute('import fes\nrun = fes.run("pair", duration=1.0, rtf=2.0)')
    shown = [
        (message["msg_type"], message["content"]["data"]["text/html"])
        for message in outputs(client, request)
        if "data" in message["content"]
    ]
    assert shown[0][0] == "display_data"
    assert shown[0][1].startswith('<progress value="')
    assert shown[-1] == ("update_display_data", "")
    assert {kind for kind, _ in shown[1:]} == {"update_display_data"}


@pytest.mark.parametrize("call", ENDLESS.values(), ids=ENDLESS)
def test_the_interrupt_of_a_notebook_ends_a_run_and_leaves_a_working_kernel(
    call: str, kernel: tuple[KernelManager, BlockingKernelClient], tmp_path: Path
) -> None:
    manager, client = kernel
    errors = []
    for message in outputs(client, client.execute(SHOW + call)):
        if message["content"].get("text") == "running\n":
            manager.interrupt_kernel()
        elif message["msg_type"] == "error":
            errors.append(message["content"]["ename"])
    assert errors == ["KeyboardInterrupt"]
    left = [message["content"].get("text") for message in outputs(client, client.execute(LEFT))]
    assert "0 False\n" in left
    assert not list(tmp_path.glob("fes-*"))
    again = outputs(client, client.execute('print(fes.run("pair", duration=0.2).digest)'))
    assert f"{fes.run('pair', duration=0.2).digest}\n" in [message["content"].get("text") for message in again]
