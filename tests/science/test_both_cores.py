"""Every scenario and every variant has one digest, whichever core computes; and it is the golden one."""

import os
import subprocess
import sys

import pytest

from agents.core import compiled_crew
from console.backends import inprocess
from fes.arithmetic.core import library
from tests.portability import cases
from tests.support import cores, golden
from tests.support.paths import ROOT

SECONDS = 1.6
"""Simulated length of a run: the faults of the variants come within 1.5 s."""

SHORT = ("pair",)
"""Scenarios that a process without the core runs at their whole length."""


@cores.needs(compiled_crew.load())
@pytest.mark.parametrize("name", cases.names())
def test_a_scenario_has_one_digest_with_either_core(name: str) -> None:
    scenario = cases.load(name, SECONDS)
    digest = inprocess.run(scenario, name)["digest"]
    with cores.only_numpy():
        assert inprocess.run(scenario, name)["digest"] == digest


@pytest.mark.slow
@pytest.mark.parametrize("core", [library.NUMPY, pytest.param(library.C, marks=cores.needs(compiled_crew.load()))])
def test_a_process_with_one_core_gives_golden_digests_at_their_whole_length(core: str) -> None:
    code = f"from tests.support import golden; print(*map(golden.computed, {SHORT!r}))"
    environment = os.environ | {library.VARIABLE: core}
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, env=environment, capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == [golden.stored()[name] for name in SHORT]
