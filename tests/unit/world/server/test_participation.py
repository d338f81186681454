"""The robots that take part at a tick, as tokens appear and are lost."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np

from tests.support.loop import load
from world.server.participation import Participation
from world.simulation import truth


def test_a_session_that_restarts_within_a_tick_costs_a_tick_and_its_robot_does_not_hang() -> None:
    """Messages to the old session are lost. A robot that was then excluded for its silence would get no others."""
    scenario = load("pair.toml")
    registry = SimpleNamespace(hosted=np.ones(2, dtype=np.bool_), alive=np.ones(2, dtype=np.uint8), renewed=set())
    registry.group = lambda robot: (robot,)
    participation = Participation(registry, scenario)  # type: ignore[arg-type]
    state = replace(truth.start(truth.create(scenario)), tick=5)
    assert participation.participating(state).tolist() == [True, True]
    participation.disconnect(1)  # and its token is back
    assert participation.reachable.tolist() == [True, False]
    participation.hang(np.array([True, True]))
    assert participation.participating(state).tolist() == [False, False]
    assert participation.participating(state).tolist() == [False, True]
    assert participation.wake(0)
    assert participation.participating(state).tolist() == [True, True]
    participation.disconnect(1)  # in the tick before it rejoins
    assert participation.participating(replace(state, present=np.array([True, False]))).tolist() == [True, True]


def test_a_robot_with_a_new_process_and_an_uninterrupted_token_misses_one_tick() -> None:
    """For example an agent that replaced another while the world was away: it starts without state."""
    registry = SimpleNamespace(hosted=np.ones(2, dtype=np.bool_), alive=np.ones(2, dtype=np.uint8), renewed={1})
    participation = Participation(registry, load("pair.toml"))  # type: ignore[arg-type]
    state = replace(truth.start(truth.create(load("pair.toml"))), tick=5)
    away = participation.participating(state)
    assert away.tolist() == [True, False]
    state = replace(truth.attend(state, away), tick=6)
    assert participation.participating(state).tolist() == [True, True]
    assert not registry.renewed
    registry.renewed.add(1)  # a robot that rejoins at this tick anyhow misses nothing
    assert participation.participating(replace(state, since=np.array([0, 6]))).tolist() == [True, True]


def test_a_session_of_several_robots_that_restarts_within_a_tick_costs_all_of_them_that_tick() -> None:
    registry = SimpleNamespace(hosted=np.ones(3, dtype=np.bool_), alive=np.ones(3, dtype=np.uint8), renewed=set())
    registry.group = lambda robot: (0, 1) if robot < 2 else (2,)
    poses = [[0.0, 0.0, 0.5], [60.0, 0.0, 2.0], [120.0, 0.0, 1.0]]
    scenario = load("pair.toml", robots__poses=poses)
    participation = Participation(registry, scenario)  # type: ignore[arg-type]
    state = replace(truth.start(truth.create(scenario)), tick=5)
    participation.disconnect(1)  # and its token is back, as is that of robot 0
    assert participation.reachable.tolist() == [False, False, True]
    assert participation.participating(state).tolist() == [False, False, True]
    assert participation.participating(state).tolist() == [True, True, True]
