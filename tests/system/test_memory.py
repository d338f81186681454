"""The memory of a run does not grow with its length; bench/size/memory.py measures a million ticks, and processes."""

import gc
import io
import subprocess
import sys

import numpy as np
import pytest
from rich.console import Console

from bench.size.memory import resident
from console.backends import inprocess
from console.dashboard import frame
from console.dashboard.history import ReportHistory
from tests.support.loop import load
from world.metrics import report_builder
from world.metrics.collector import MetricsCollector

TICKS, WARM_UP = 40_000, 10_000


def test_world_robots_metrics_and_dashboard_of_a_long_run_do_not_grow() -> None:
    scenario = load("pair.toml", run__duration=TICKS * 0.02)
    metrics, shown = MetricsCollector(scenario), ReportHistory()
    paper, alive, before = Console(file=io.StringIO(), width=80, height=24), np.ones(2, dtype=np.uint8), 0.0
    for done, tick in enumerate(inprocess.ticks(scenario), 1):
        metrics.add(tick.state, tick.twists, tick.telemetry)
        if done % 50 == 0:
            shown.add(report_builder.build(metrics, "memory", alive, 0.02 * done, 50.0))
            paper.print(frame.render(shown, 80, 24))
            paper.file = io.StringIO()
        if done == WARM_UP:
            gc.collect()
            before = resident()
    gc.collect()
    assert resident() - before < 1.5  # MB; a leak of 50 bytes per tick would take as much


@pytest.mark.parametrize(
    "program",
    [
        "import sys; from console import cli; cli.load = fail; sys.argv = ['fes', 'run', 'pair']; cli.main()",
        "from fes import process\nasync def main(): fail()\nprocess.run('fes', main)",
    ],
)
def test_a_failed_allocation_is_reported_in_one_line(program: str) -> None:
    fail = "import numpy\ndef fail(*given): numpy.zeros(2**59)\n"
    ended = subprocess.run([sys.executable, "-c", fail + program], capture_output=True, text=True, check=False)
    assert ended.returncode == 1
    assert ended.stderr.startswith("fes: error: not enough memory: Unable to allocate 4.00 EiB")
    assert ended.stderr.count("\n") == 1
