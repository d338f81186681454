"""Reception probabilities between robots on the table, at their true poses at full size."""

from typing import NamedTuple

import numpy as np

from fes.arrays.types import Bools, Floats
from fes.errors import ScenarioError
from fes.model import counts
from world.config.scenario import Scenario
from world.simulation import channel, neighbor_list, reception
from world.simulation.channel import RadioInput

MAX_ROBOTS = 100
"""Largest team on a table: the relay has numbers for each directed pair."""


class Reach(NamedTuple):
    """The pairs in range at one time, by sender and receiver."""

    in_range: Bools
    """True within communication range [n, n]."""
    probability: Floats
    """Probability that a beacon decodes; 0 beyond the range [n, n]."""


class Reachability:
    """The channel of a scenario's start; raises ScenarioError for one that a relay cannot have."""

    def __init__(self, scenario: Scenario) -> None:
        number = scenario.robots.number
        if number > MAX_ROBOTS:
            raise ScenarioError("robots", f"a table has room for at most {MAX_ROBOTS} robots, got {number}")
        if scenario.channel.bursts is not None:
            raise ScenarioError("channel.bursts", "a table has none: its datagrams have no common tick")
        context = reception.context(scenario)
        reception.prepare([scenario.channel], context)
        self._scenario = scenario
        self._medium = channel.medium(scenario.run.seed, context)
        self._ids, self._present = np.arange(number), np.ones(number, dtype=np.bool_)

    def measure(self, poses: Floats, time: float) -> Reach:
        """The pairs in range at `poses` [n, 3] [m, m, rad; at full size], at a `time` of the run [s]."""
        config, number = self._scenario.channel, len(self._ids)
        near = neighbor_list.measure(self._ids, poses, config.communication_range, None)
        robots = RadioInput(counts.ticks(time, self._scenario.run.dt), poses, self._present, near)
        probability = channel.reception_probability(self._medium, config, robots, near)
        reach = Reach(np.zeros((number, number), dtype=np.bool_), np.zeros((number, number)))
        pairs = near.edges.peers, near.edges.rows
        reach.in_range[pairs] = True
        reach.probability[pairs] = probability
        return reach
