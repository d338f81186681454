"""Robots that stand still, and the radio's ledger of their contacts."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from world.config.scenario import Scenario, parse
from world.simulation import truth
from world.simulation.truth import State, World

Pair = tuple[int, int]
EVERYTHING: dict[str, Any] = {
    "model": "logistic",
    "logistic_midpoint": 90.0,
    "shadowing": {"deviation": 6.0, "decorrelation_distance": 15.0},
    "bursts": {"bad_share": 0.1, "mean_length": 0.2, "loss": 0.9},
    "jammers": [
        {"x": 10.0, "y": -20.0, "radius": 30.0},
        {"x": 90.0, "y": 0.0, "radius": 5.0, "reception_factor": 0.5},
    ],
}


def team(positions: Iterable[tuple[float, float]], **channel: Any) -> Scenario:
    poses = [[x, y, 0.0] for x, y in positions]
    return parse({"schema": 1, "run": {"seed": 4}, "robots": {"poses": poses}, "channel": channel}, "here")


def started(scenario: Scenario) -> tuple[World, State]:
    world = truth.create(scenario)
    return world, truth.start(world)


def stand(world: World, state: State, ticks: int = 1) -> State:
    for _ in range(ticks):
        state = truth.step(world, state, np.zeros((len(state.poses), 2)))
    return state


def ledger(state: State, name: str) -> dict[Pair, float]:
    """One column of the radio, by (receiver, sender)."""
    edges = state.radio.edges
    pairs = zip(edges.rows.tolist(), edges.peers.tolist(), strict=True)
    return dict(zip(pairs, getattr(state.radio, name).tolist(), strict=True))
