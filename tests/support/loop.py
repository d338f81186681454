"""World and crews in one loop, in one process, with a history of every tick."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from agents.control import crew as crews
from fes.arrays.edges import Edges
from fes.arrays.types import Floats, Ints
from fes.model.sensing import Beacons, Observations, no_beacons
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
        said = self.estimates[tick]
        return sum(abs(said[i, j] - said[j, i]) for i, j in said if i < j and (j, i) in said)


def load(name: str, **overrides: Any) -> Scenario:
    """A scenario of configs/; overrides with `__` for the dot."""
    return scenario.load(CONFIGS / name, {path.replace("__", "."): value for path, value in overrides.items()})


def run(what: Scenario, ticks: int | None = None, split: list[list[int]] | None = None) -> History:
    """Run a scenario as one crew, or `split` into several that exchange beacons."""
    world = truth.create(what)
    state = truth.start(world)
    config = scenario.agent_config(what)
    everybody = world.ids.tolist()
    parts = [crews.create(config, np.array(ids)) for ids in (split or [everybody])]
    minds = [crews.start(part) for part in parts]
    said = [no_beacons()] * len(parts)
    history = History(what.run.dt, [], [])
    for _ in range(ticks or what.ticks):
        sensed = truth.observe(state)
        twists = np.full((len(everybody), 2), np.nan)
        heard = said[0] if split is None else _together(said)
        for at, part in enumerate(parts):
            own = sensed if split is None else _own(sensed, part.ids)
            audible = heard if split is None else _among(heard, np.unique(own.in_range.peers))
            minds[at], said[at], twists[part.ids] = crews.step(part, minds[at], own, audible)
        history.poses.append(state.poses)
        history.estimates.append({pair: value for beacons in said for pair, value in _estimates(beacons)})
        state = truth.step(world, state, twists)
    return history


def _estimates(said: Beacons) -> list[tuple[Pair, float]]:
    robots = said.links.ids[said.links.rows].tolist()
    pairs = zip(robots, said.links.peers.tolist(), strict=True)
    return list(zip(pairs, said.estimates.tolist(), strict=True))


def _own(sensed: Observations, ids: Ints) -> Observations:
    """Observations of the robots `ids` only."""
    near = sensed.in_range
    mine = np.isin(near.ids[near.rows], ids)
    rows = np.searchsorted(ids, near.ids[near.rows[mine]])
    return Observations(sensed.tick, sensed.poses[ids], Edges(ids, rows, near.peers[mine]), sensed.reception[mine])


def _together(said: list[Beacons]) -> Beacons:
    """The beacons of several crews as one, in the order of the robots' ids."""
    ids = np.concatenate([part.ids for part in said])
    order = np.argsort(ids)
    robots = np.concatenate([part.links.ids[part.links.rows] for part in said])
    peers = np.concatenate([part.links.peers for part in said])
    by_pair = np.lexsort([peers, robots])
    links = Edges(ids[order], np.searchsorted(ids[order], robots[by_pair]), peers[by_pair])
    estimates = np.concatenate([part.estimates for part in said])[by_pair]
    named = np.concatenate([part.selected for part in said])[by_pair]
    poses = np.concatenate([part.poses for part in said])[order]
    statistics = np.concatenate([part.statistics for part in said])[order]
    return Beacons(said[0].tick, ids[order], poses, links, estimates, named, statistics)


def _among(said: Beacons, ids: Ints) -> Beacons:
    """Only the beacons of robots `ids`."""
    senders = np.isin(said.ids, ids)
    kept = said.ids[senders]
    robots = said.links.ids[said.links.rows]
    mine = np.isin(robots, kept)
    links = Edges(kept, np.searchsorted(kept, robots[mine]), said.links.peers[mine])
    return Beacons(
        said.tick,
        kept,
        said.poses[senders],
        links,
        said.estimates[mine],
        said.selected[mine],
        said.statistics[senders],
    )
