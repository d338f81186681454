"""The rivals keep their digits in a stack of runs, as all laws do."""

import pytest

from console.backends import stacked
from tests.support.loop import load
from tests.support.results import alone, without_wall_clock
from world.config.builtin import file_of
from world.config.outside import schemes

NAMES = [scheme.name for scheme in schemes.of_file(file_of("challenge")).scheme]


@pytest.mark.parametrize("name", NAMES[4:])
def test_a_stacked_run_of_a_rival_has_the_summary_and_digest_of_a_single_run(name: str) -> None:
    scenarios = [load("challenge.toml", scheme=name, run__seed=seed, run__duration=2.0) for seed in (3, 0)]
    assert [without_wall_clock(summary) for summary in stacked.run(scenarios, "x")] == alone(scenarios)
