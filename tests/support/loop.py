"""World and crews in one loop, in one process, with a history of every tick."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from agents.control import crew as crews
from agents.control.state import Crew, CrewState
from agents.runtime.reception import Receiver
from fes.arrays.edges import Edges
from fes.arrays.types import Floats, Ints
from fes.model.sensing import Beacons, Observations, Telemetry, no_beacons
from tests.support.paths import CONFIGS
from world.config import scenario
from world.config.scenario import Scenario
from world.simulation import truth

Pair = tuple[int, int]


@dataclass(frozen=True)
class History:
    """History of a run, tick by tick."""

    dt: float
    poses: list[Floats]
    """[n, 3] before each tick's twists."""
    estimates: list[dict[Pair, float]]
    """r_hat of each link (robot, peer) [m]."""

    def edges(self, tick: int) -> set[Pair]:
        """Pairs a < b that are linked in either direction."""
        return {(min(pair), max(pair)) for pair in self.estimates[tick]}

    def separation(self, tick: int, pair: Pair) -> float:
        """True separation [m]."""
        difference = self.poses[tick][pair[0], :2] - self.poses[tick][pair[1], :2]
        return float(np.hypot(difference[0], difference[1]))

    def disagreement(self, tick: int) -> float:
        """Sum of |r_ij - r_ji| over the pairs linked in both directions [m]."""
        estimates = self.estimates[tick]
        return sum(abs(estimates[i, j] - estimates[j, i]) for i, j in estimates if i < j and (j, i) in estimates)


def load(name: str, **overrides: Any) -> Scenario:
    """A scenario of configs/; overrides with `__` for the dot."""
    return scenario.load(CONFIGS / name, {path.replace("__", "."): value for path, value in overrides.items()})


def tick(
    crew: Crew, state: CrewState, receiver: Receiver, observations: Observations, beacons: Beacons
) -> tuple[CrewState, Beacons, Floats, Telemetry]:
    """One tick of a crew: `receiver` keeps those of the last tick's `beacons` that decoded, and the crew steps."""
    received = receiver.receive(observations, beacons, state.contacts.edges)
    return crews.step(crew, state, observations.sensed, received)


def run(what: Scenario, ticks: int | None = None, split: list[list[int]] | None = None) -> History:
    """Run a scenario as one crew, or `split` into several that exchange beacons."""
    world = truth.create(what)
    state = truth.start(world)
    config = scenario.agent_config(what)
    everybody = world.ids.tolist()
    parts = [crews.create(config, np.array(ids)) for ids in (split or [everybody])]
    minds, receivers = [crews.start(part) for part in parts], [Receiver() for _ in parts]
    beacons = [no_beacons()] * len(parts)
    history = History(what.run.dt, [], [])
    for _ in range(ticks or what.ticks):
        sensed = truth.observe(state)
        twists = np.full((len(everybody), 2), np.nan)
        heard = beacons[0] if split is None else _together(beacons)
        for index, part in enumerate(parts):
            own = sensed if split is None else _own(sensed, part.ids)
            audible = heard if split is None else _among(heard, np.unique(own.in_range.peers))
            stepped = tick(part, minds[index], receivers[index], own, audible)
            minds[index], beacons[index], twists[part.ids], _ = stepped
        history.poses.append(state.poses)
        history.estimates.append({pair: value for part in beacons for pair, value in _estimates(part)})
        state = truth.step(world, state, twists)
    return history


def _estimates(beacons: Beacons) -> list[tuple[Pair, float]]:
    robots = beacons.links.ids[beacons.links.rows].tolist()
    pairs = zip(robots, beacons.links.peers.tolist(), strict=True)
    return list(zip(pairs, beacons.estimates.tolist(), strict=True))


def _own(sensed: Observations, ids: Ints) -> Observations:
    """Observations of the robots `ids` only."""
    near = sensed.in_range
    mine = np.isin(near.ids[near.rows], ids)
    rows = np.searchsorted(ids, near.ids[near.rows[mine]])
    return Observations(sensed.tick, sensed.poses[ids], Edges(ids, rows, near.peers[mine]), sensed.reception[mine])


def _together(beacons: list[Beacons]) -> Beacons:
    """The beacons of several crews as one, in the order of the robots' ids."""
    ids = np.concatenate([part.ids for part in beacons])
    order = np.argsort(ids)
    robots = np.concatenate([part.links.ids[part.links.rows] for part in beacons])
    peers = np.concatenate([part.links.peers for part in beacons])
    by_pair = np.lexsort([peers, robots])
    links = Edges(ids[order], np.searchsorted(ids[order], robots[by_pair]), peers[by_pair])
    estimates = np.concatenate([part.estimates for part in beacons])[by_pair]
    selected = np.concatenate([part.selected for part in beacons])[by_pair]
    poses = np.concatenate([part.poses for part in beacons])[order]
    statistics = np.concatenate([part.statistics for part in beacons])[order]
    declared = np.concatenate([part.declared for part in beacons])[order]
    return Beacons(beacons[0].tick, ids[order], poses, links, estimates, selected, statistics, declared)


def _among(beacons: Beacons, ids: Ints) -> Beacons:
    """Only the beacons of robots `ids`."""
    senders = np.isin(beacons.ids, ids)
    sender_ids = beacons.ids[senders]
    robots = beacons.links.ids[beacons.links.rows]
    mine = np.isin(robots, sender_ids)
    links = Edges(sender_ids, np.searchsorted(sender_ids, robots[mine]), beacons.links.peers[mine])
    return Beacons(
        beacons.tick,
        sender_ids,
        beacons.poses[senders],
        links,
        beacons.estimates[mine],
        beacons.selected[mine],
        beacons.statistics[senders],
        beacons.declared[senders],
    )
