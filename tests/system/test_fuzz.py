"""Random and damaged messages into the compiled core, for seconds; `python -m tests.fuzz 600` is the long form."""

import re
import subprocess
from pathlib import Path

import pytest

import build_core
from tests.fuzz import build

pytestmark = [pytest.mark.slow]


@pytest.mark.parametrize("name", build.PROGRAMS)
def test_no_message_makes_the_core_read_or_write_beyond_its_memory(name: str, tmp_path: Path) -> None:
    try:
        program = build.build(name, tmp_path)
    except (build_core.NotBuilt, subprocess.CalledProcessError) as reason:
        pytest.skip(f"no compiler with sanitizers: {reason}")
    counts = re.fullmatch(r"(\d+) answered, (\d+) left to Python", build.run(program, 5, seed=1))
    assert counts is not None
    assert min(map(int, counts.groups())) > 100
