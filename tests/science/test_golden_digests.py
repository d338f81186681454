"""Each scenario gives its golden digest, here as on every other processor; those of faults are in test_faults."""

import pytest

from tests.support import golden
from tests.support.paths import CONFIGS
from world.config import builtin
from world.config.scenario import load

IN_FULL = [name for name in builtin.names() if "/" not in name and name not in ("compose", *dict(golden.CUT))]


def test_every_scenario_has_a_golden_digest() -> None:
    assert sorted(golden.stored()) == sorted(builtin.names())


@pytest.mark.parametrize("name", IN_FULL)
def test_a_scenario_gives_its_golden_digest(name: str) -> None:
    assert golden.computed(name) == golden.stored()[name]


@pytest.mark.parametrize(("name", "seconds"), golden.CUT)
def test_the_first_seconds_of_a_long_scenario_give_their_golden_digest(name: str, seconds: float) -> None:
    assert golden.computed(name, seconds) == golden.stored_cut(name, seconds)


def test_the_scenario_of_compose_has_the_digest_of_the_same_team_elsewhere() -> None:
    compose, elsewhere = (load(CONFIGS / f"{name}.toml") for name in ("compose", "neighborhood"))
    assert compose.model_copy(update={"expect": elsewhere.expect}) == elsewhere
    assert golden.stored()["compose"] == golden.stored()["neighborhood"]
