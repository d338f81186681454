"""The start of an agent loads and reads no more than it needs."""

import subprocess
import sys

from tests.support.processes import PATIENCE


def test_an_agent_that_starts_reads_no_source() -> None:
    # Descriptions would cost it the time to parse its own modules.
    code = "import inspect; del inspect.findsource; import agents.process"
    subprocess.run([sys.executable, "-c", code], check=True, timeout=PATIENCE)
