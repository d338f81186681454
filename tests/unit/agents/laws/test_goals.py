"""The law of goals: who is pulled where, by the id within the run."""

from typing import Any

import numpy as np
import pytest

from agents.control import crew
from console.backends import stacked
from fes.errors import FesError
from fes.extension import registry
from fes.extension.kinds import FORMATION
from fes.model.table import Use
from tests.support import loop
from world.config.scenario import agent_config

GOALS = [[10.0, 0.0], [20.0, 5.0]]


def law(goals: list[Any]) -> Use:
    return Use.model_validate({"use": "goals", "goals": goals})


def test_robots_arrive_at_their_goals_and_one_without_a_goal_stays() -> None:
    scenario = loop.load(
        "pair.toml",
        run__duration=20.0,
        robots__poses=[[0.0, 0.0, 0.5], [100.0, 0.0, 2.0], [50.0, 50.0, 1.0]],
        formation__law={"use": "goals", "goals": GOALS},
    )
    poses = loop.run(scenario).poses
    # at mu = 1 /s, exp(-20) of 100 m is left
    assert poses[-1][:2, :2] == pytest.approx(np.array(GOALS), abs=1e-3)
    assert poses[-1][2].tolist() == [50.0, 50.0, 1.0]


def test_a_crew_of_one_robot_takes_the_goal_of_its_id() -> None:
    scenario = loop.load("pair.toml", run__duration=2.0, formation__law={"use": "goals", "goals": GOALS})
    together, apart = loop.run(scenario), loop.run(scenario, split=[[0], [1]])
    assert np.array(together.poses).tobytes() == np.array(apart.poses).tobytes()


def test_stacked_runs_have_the_goals_of_the_ids_in_their_own_runs() -> None:
    runs = [
        loop.load("pair.toml", run__duration=1.0, run__seed=seed, formation__law={"use": "goals", "goals": GOALS})
        for seed in (1, 2)
    ]
    *_, last = stacked.ticks(runs)
    assert last[0].state.poses.tobytes() == last[1].state.poses.tobytes()


@pytest.mark.parametrize(
    ("goals", "rule"),
    [([], "at least 1 item"), ([[1.0]], "Field required|is required"), ([[1.0, 1e300]], "less than or equal to")],
)
def test_goals_that_are_not_places_are_rejected_in_one_line(goals: list[Any], rule: str) -> None:
    with pytest.raises(FesError, match=rule) as caught:
        registry.check(FORMATION, law(goals))
    assert "\n" not in str(caught.value)


def test_a_law_without_its_goals_is_rejected_in_one_line() -> None:
    scenario = loop.load("pair.toml", formation__law="goals")
    with pytest.raises(FesError, match=r"^formation law 'goals': goals: is required$"):
        crew.create(agent_config(scenario), np.arange(2))
