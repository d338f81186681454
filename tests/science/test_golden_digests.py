"""Each scenario gives its golden digest, here as on every other processor."""

import pytest

from tests.support import golden
from world.config import builtin


def test_every_scenario_has_a_golden_digest() -> None:
    assert sorted(golden.stored()) == sorted(builtin.names())


@pytest.mark.parametrize("name", builtin.names())
def test_a_scenario_gives_its_golden_digest(name: str) -> None:
    assert golden.computed(name) == golden.stored()[name]
