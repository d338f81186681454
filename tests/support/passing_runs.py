"""Many teams that pass each other, far apart in one world: the least separation of each, and the conditions it kept.

World and crew are those of the product. Each team lies SPACING from the next, so that it hears no robot of another.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from agents.control import crew as crews
from agents.control.state import Crew, CrewState
from agents.runtime.reception import Receiver
from fes.arrays.edges import Edges
from fes.arrays.types import Bools, Floats, Ints
from fes.model.config import FormationConfig
from fes.model.sensing import OPENING_TICKS, no_beacons
from tests.support import loop
from world.config.scenario import Scenario, agent_config, parse
from world.simulation import truth
from world.simulation.truth import State

SPACING = 2500.0
"""Distance between the centers of two teams [m]: at 5 m/s for 150 s, two of them stay 1,000 m apart."""

LONGEST = 150.0
"""Time to arrive [s]."""

ARRIVED = 0.5
"""Distance from a goal at which a robot has arrived [m]."""

AFTERWARDS = 2.0
"""Time for which a batch runs after the last arrival [s]."""

ROUNDING = 1e-9
"""[m]; coordinates of 1e5 m resolve 1e-11 m."""


class Team(NamedTuple):
    """One run: the robots of a team, about its center."""

    kind: str
    starts: Floats
    """Poses at tick 0 [n, 3]."""
    goals: Floats
    """[n, 2]; a row of NaN for a robot that goes to none."""
    event: dict[str, Any]
    """An event of its robots, with ids within the team."""


@dataclass(frozen=True)
class Batch:
    """Teams that run under one configuration."""

    teams: Sequence[Team]
    formation: dict[str, Any] = field(default_factory=dict)
    """Fields of this table that replace the usual ones."""
    tables: dict[str, Any] = field(default_factory=dict)
    """Whole tables of the scenario."""
    longest: float = LONGEST
    clock_skew: float = 0.0
    """Largest skew of a clock [s]."""
    wrap: Callable[[Crew, Floats], Crew] = lambda crew, goals: crew
    """Replaces a law of the crew, given the goals [m, 2] of all robots."""


class Outcome(NamedTuple):
    """The result of one team."""

    kind: str
    least: float
    """Least separation [m]."""
    is_broken: bool
    """True if it did not keep the conditions of docs/explanation/safe-separation.md at every tick."""
    arrived: float
    """Time at which all robots with goals were there [s]; infinite if they never were."""


def run(batch: Batch) -> list[Outcome]:
    """The outcome of each team of a batch."""
    what, goals, team = scenario(batch), placed(batch)[1], _team_of_each(batch)
    world, count, dt = truth.create(what), len(batch.teams), what.run.dt
    crew = batch.wrap(crews.create(agent_config(what), world.ids), goals)
    state, memory, beacons, receiver = truth.start(world), crews.start(crew), no_beacons(), Receiver()
    least, is_broken, arrived = np.full(count, np.inf), np.zeros(count, dtype=np.bool_), np.full(count, np.inf)
    has_goals = np.bincount(team, ~np.isnan(goals[:, 0]), count) > 0
    for tick in range(what.ticks):
        memory, beacons, twists, _ = loop.tick(crew, memory, receiver, truth.observe(state), beacons)
        pairs = state.proximity.candidates
        np.minimum.at(least, team[pairs.a], state.proximity.separation)
        is_broken[team[broken(state, memory, what)]] = True
        is_away = np.hypot(*(state.poses[:, :2] - goals).T) >= ARRIVED
        is_there = has_goals & (np.bincount(team, is_away & state.present, count) == 0)
        arrived = np.where(is_there & np.isinf(arrived), tick * dt, arrived)
        if tick * dt > arrived.max() + AFTERWARDS:
            break
        state = truth.step(world, state, truth.held(state, twists))
    kinds = [team.kind for team in batch.teams]
    return [
        Outcome(*values) for values in zip(kinds, least.tolist(), is_broken.tolist(), arrived.tolist(), strict=True)
    ]


def scenario(batch: Batch) -> Scenario:
    """All teams of a batch in one scenario."""
    poses, goals = placed(batch)
    stays = np.isnan(goals)
    law = {"use": "goals", "goals": np.where(stays, poses[:, :2], goals).tolist()}
    first = np.cumsum([0, *(len(team.starts) for team in batch.teams)]).tolist()
    events = [
        _shifted(team.event, offset) for team, offset in zip(batch.teams, first[:-1], strict=True) if team.event
    ]
    tables: dict[str, Any] = {
        "schema": 1,
        "run": {"duration": batch.longest, "seed": 1, "clock_skew": batch.clock_skew},
        "robots": {"poses": poses.tolist()},
        "seeking": {"use": "fixed_separation"},
        "formation": {"linear_limit": 5.0, "safe_separation": 5.0, "law": law} | batch.formation,
        "event": events,
    }
    return parse(tables | batch.tables, "passing")


def broken(state: State, memory: CrewState, what: Scenario) -> Bools:
    """True for a robot that does not know where a peer is, and drives near enough for a collision [n]."""
    result = np.zeros(len(state.poses), dtype=np.bool_)
    drives = state.present if state.tick >= OPENING_TICKS else result
    pairs = state.proximity.candidates
    is_close = state.proximity.separation < near_within(what.formation)
    if not is_close.any():
        return result
    for robots, peers in ((pairs.a, pairs.b), (pairs.b, pairs.a)):
        robots, peers = robots[is_close], peers[is_close]
        is_blind = drives[robots] & ~is_known(state, memory, what, robots, peers)
        result[robots[is_blind]] = True
    return result


def near_within(formation: FormationConfig) -> float:
    """Separation from which the bound on the closing speed is below the largest speed [m]."""
    assert formation.safe_separation is not None
    assert formation.linear_limit is not None
    return formation.safe_separation + 2.0 * formation.linear_limit / formation.separation_gain


def is_known(state: State, memory: CrewState, what: Scenario, robots: Ints, peers: Ints) -> Bools:
    """True where a robot has heard the peer in time, at a place from which the peer can have come to where it is."""
    contacts, limit = memory.contacts, what.formation.linear_limit
    assert limit is not None
    positions = contacts.edges.find(Edges.key(robots, peers))
    if not len(contacts.edges):
        return positions >= 0
    reach = limit * what.run.dt * (state.tick - contacts.heard[positions])
    dx, dy = contacts.x[positions] - state.poses[peers, 0], contacts.y[positions] - state.poses[peers, 1]
    known: Bools = (positions >= 0) & contacts.known[positions] & (np.hypot(dx, dy) <= reach + ROUNDING)
    return known


def placed(batch: Batch) -> tuple[Floats, Floats]:
    """The poses [m, 3] and goals [m, 2] of all robots."""
    width, team = math.ceil(math.sqrt(len(batch.teams))), _team_of_each(batch)
    centers = SPACING * np.stack([team % width, team // width], axis=1)
    poses = np.concatenate([team.starts for team in batch.teams])
    poses[:, :2] += centers
    return poses, np.concatenate([team.goals for team in batch.teams]) + centers


def _team_of_each(batch: Batch) -> Ints:
    """The team of each robot [m]."""
    return np.repeat(np.arange(len(batch.teams)), [len(team.starts) for team in batch.teams])


def _shifted(event: dict[str, Any], first: int) -> dict[str, Any]:
    """An event of a team for the robots of the batch, of which `first` is its robot 0."""
    shifted = dict(event)
    if "kill" in event:
        shifted["kill"] = [robot + first for robot in event["kill"]]
    if "transmitter" in event:
        shifted["transmitter"] = event["transmitter"] | {"robot": event["transmitter"]["robot"] + first}
    return shifted
