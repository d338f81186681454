"""Calls in a thread of their own, and interrupts at any moment of the wait for them."""

import subprocess
import sys

from tests.support.paths import ROOT
from tests.support.processes import PATIENCE


def test_a_call_ends_with_the_interrupt_at_whichever_instruction_that_comes() -> None:
    script = [sys.executable, "-m", "tests.support.interrupts", "3000"]
    ended = subprocess.run(script, cwd=ROOT, capture_output=True, text=True, timeout=PATIENCE, check=False)
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, "all ended\n", "")
