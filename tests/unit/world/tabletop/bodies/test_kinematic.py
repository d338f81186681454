"""Exact bodies on a table: arcs, top speeds, and the scale."""

import math
import re
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fes.errors import FesError
from fes.system import distribution
from tests.support import loop
from world.config.hardware.tabletop import TabletopConfig
from world.tabletop.bodies import team
from world.tabletop.bodies.kinematic import KinematicBodies

CONFIG = TabletopConfig()
ORIGIN = np.zeros((1, 3))


def test_a_body_drives_a_full_circle_back_to_its_start() -> None:
    bodies = KinematicBodies(ORIGIN, CONFIG)
    bodies.command(0, 0.1, math.pi / 2)
    for _ in range(400):
        bodies.step(0.01)  # 4 s in all: one turn
    assert bodies.poses()[0, :2] == pytest.approx([0.0, 0.0], abs=1e-12)
    for _ in range(200):
        bodies.step(0.01)
    assert bodies.poses()[0, :2] == pytest.approx([0.0, 2 * 0.1 / (math.pi / 2)], abs=1e-12)  # a diameter to the left


@given(st.floats(-1.0, 1.0), st.floats(-10.0, 10.0), st.floats(-3.0, 3.0))
@settings(max_examples=50, deadline=None)
def test_no_body_exceeds_its_top_speeds(linear: float, angular: float, heading: float) -> None:
    bodies = KinematicBodies(np.array([[0.3, -0.2, heading]]), CONFIG)
    bodies.command(0, linear, angular)
    bodies.step(0.01)
    moved = bodies.poses()[0] - [0.3, -0.2, heading]
    assert math.hypot(*moved[:2]) <= 0.2 * 0.01 + 1e-12
    assert abs(math.remainder(moved[2], math.tau)) <= 3.6 * 0.01 + 1e-12
    assert bodies.twists()[0] == pytest.approx([np.clip(linear, -0.2, 0.2), np.clip(angular, -3.6, 3.6)])


def test_a_command_moves_its_own_body_alone() -> None:
    bodies = KinematicBodies(np.zeros((3, 3)), CONFIG)
    bodies.command(1, 0.1, 0.0)
    bodies.step(1.0)
    assert bodies.poses()[:, 0] == pytest.approx([0.0, 0.1, 0.0])


def test_a_team_starts_where_its_scenario_says_at_the_tables_scale() -> None:
    scenario = loop.load("tabletop.toml", tabletop__scale=50.0)
    assert scenario.tabletop is not None
    bodies = team.create(scenario, scenario.tabletop)
    assert bodies.poses()[6] == pytest.approx([4.5, 0.0, 1.05])  # 225 m
    assert team.at_full_size(bodies.poses(), 50.0)[6] == pytest.approx([225.0, 0.0, 1.05])


def test_bodies_in_mujoco_name_the_package_that_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(FesError, match=re.escape(distribution.install("mujoco"))):
        team.create(loop.load("tabletop.toml"), TabletopConfig(body="mujoco"))
