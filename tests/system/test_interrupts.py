"""Calls in a thread of their own, and interrupts at any moment of the wait for them."""

import subprocess
import sys

from tests.support.paths import ROOT
from tests.support.processes import PATIENCE


def test_an_interrupt_at_any_moment_ends_a_call() -> None:
    script = [sys.executable, "-m", "tests.support.interrupts", "3000"]
    ended = subprocess.run(script, cwd=ROOT, capture_output=True, text=True, timeout=PATIENCE, check=False)
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, "all ended\n", "")
