"""A run that several tests stop."""

import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.paths import CONFIGS
from tests.support.processes import fes, start


@pytest.fixture
def endless(tmp_path: Path) -> Iterator["subprocess.Popen[str]"]:
    """A very long run of two robots."""
    running = start(
        fes("run", str(CONFIGS / "pair.toml"), "--duration", "100000", "--out", "out", "--json"), tmp_path
    )
    yield running
    if running.poll() is None:
        running.kill()
    running.communicate()
