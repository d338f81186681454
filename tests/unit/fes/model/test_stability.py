"""The rules of the safe separation: the world rejects a scenario by them, and a crew its settings."""

from typing import Any

import numpy as np
import pytest

from agents.control import crew
from fes.errors import FesError, ScenarioError
from tests.support import loop
from world.config.scenario import agent_config

SAFE = {"safe_separation": 5.0, "linear_limit": 5.0}
BROKEN = [
    ({"safe_separation": 5.0}, "formation.safe_separation needs formation.linear_limit, got 5 without it"),
    (
        SAFE | {"safe_separation": 25.0, "linear_limit": 50.0},
        "formation.safe_separation must be below half of objective.minimum_separation, 25 m, got 25",
    ),
    (
        SAFE | {"linear_limit": 2.0},
        "formation.separation_gain must be at most formation.linear_limit / formation.safe_separation, 0.4 /s, got 1",
    ),
    (
        {"safe_separation": 0.01, "linear_limit": 5.0, "separation_gain": 50.0},
        "formation.separation_gain x run.dt must be below 1, got 1: it cannot be stable",
    ),
]


@pytest.mark.parametrize(("settings", "rule"), BROKEN)
def test_the_world_and_a_crew_reject_a_safe_separation_that_cannot_be_kept(
    settings: dict[str, Any], rule: str
) -> None:
    changes: dict[str, Any] = {f"formation__{name}": value for name, value in settings.items()}
    with pytest.raises(ScenarioError, match=f"{rule}$") as refused:
        loop.load("pair.toml", **changes)
    assert "\n" not in str(refused.value)
    config = agent_config(loop.load("pair.toml"))
    formation = config.formation.model_copy(update=settings)
    with pytest.raises(FesError) as caught:
        crew.create(config.model_copy(update={"formation": formation}), np.arange(2))
    assert str(caught.value) == f"the run's settings: {rule}"


def test_gains_of_the_filter_do_not_matter_without_a_safe_separation() -> None:
    assert loop.load("pair.toml", formation__separation_gain=1e3, formation__linear_limit=1e-3)


def test_the_largest_gain_of_the_filter_is_allowed() -> None:
    assert loop.load("pair.toml", formation__safe_separation=5.0, formation__linear_limit=5.0)
