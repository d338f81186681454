"""A log whose reader does not read holds up no program."""

import os
import subprocess
import sys

from tests.support.paths import ROOT

PROGRAM = """
import logging, os, sys
from fes.system import background_log
logging.basicConfig(level=logging.INFO)
background_log.detach()
for number in range(20_000):
    logging.getLogger("gate").info("%s", "x" * 200)
os.write(int(sys.argv[1]), b"done")
os._exit(0)
"""


def test_a_pipe_that_is_never_read_does_not_stop_the_program() -> None:
    told, tell = os.pipe()
    unread, full = os.pipe()
    with subprocess.Popen(
        [sys.executable, "-c", PROGRAM, str(tell)], cwd=ROOT, stderr=full, pass_fds=[tell]
    ) as process:
        os.close(tell)
        assert os.read(told, 4) == b"done"
        assert process.wait() == 0
    for number in (told, unread, full):
        os.close(number)
