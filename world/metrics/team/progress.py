"""The team index of a run against its target: at the last tick, and the times from which it stays close to it."""

import math
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from fes.arrays.types import Ints
from fes.extension import registry
from fes.extension.kinds import FORMATION
from fes.model import counts
from fes.model.config import ObjectiveConfig
from fes.model.quantities import TEAM_LEVELS
from fes.model.sensing import Telemetry
from fes.model.table import chosen
from world.config.radio import RadioConfig
from world.config.scenario import Scenario
from world.metrics import graphs
from world.metrics.team import coverage, delivery
from world.metrics.team.target import target
from world.metrics.team.team_index import MAX_ROBOTS, TeamIndex, team_index
from world.simulation import reception
from world.simulation.truth import State

PERIOD = 0.1
"""Time between two values of the team index [s; simulated]."""


DETAILS = ("slot", "plan")
"""Details of a formation law that takes up a configuration."""

NO_PLAN = 2
"""Plan of a robot without one."""


class TeamValues(NamedTuple):
    """The team at one tick; NaN for a value that does not exist."""

    team_index: float = math.nan
    """The team index F."""
    target: float = math.nan
    """F of the shape that the team takes up, at its r_beta."""
    delivery: float = math.nan
    """Geometric mean over pairs of the quality of their best route, after the worst loss: a factor of F."""


@dataclass(eq=False)
class TeamProgress:
    """Follows the team index of a run; call `add` once per tick, in order."""

    scenario: Scenario
    latest: TeamValues = field(default_factory=TeamValues)
    """The values at the last tick that is a multiple of PERIOD."""
    _tick: int = -1
    """Tick of `latest`."""
    _since: dict[str, int | None] = field(default_factory=lambda: dict.fromkeys(TEAM_LEVELS))
    """Tick from which the index has been at each level."""
    _channel: RadioConfig | None = None
    _targets: dict[int, float] = field(default_factory=dict)
    """Number of robots -> target over `_channel`."""

    def add(self, state: State) -> None:
        """Add a tick."""
        if state.tick % counts.ticks_of(PERIOD, self.scenario.run.dt):
            return
        self.latest, self._tick = self._computed(state), state.tick
        for name, share in TEAM_LEVELS.items():
            if not (self.latest.target > 0.0 and self.latest.team_index >= share * self.latest.target):
                self._since[name] = None
            elif self._since[name] is None:
                self._since[name] = state.tick

    def values(self, state: State) -> TeamValues:
        """The values at the last tick, whose state is `state`. It changes nothing: observers may ask at any tick."""
        return self.latest if state.tick == self._tick else self._computed(state)

    def times(self) -> dict[str, float | None]:
        """For each level the time [s] from which `latest` stayed at it, so far; None if it is not there now."""
        dt = self.scenario.run.dt
        return {name: None if tick is None else round(tick * dt, 9) for name, tick in self._since.items()}

    def table(self, state: State, telemetry: Telemetry) -> dict[str, Any]:
        """The values of a summary, at the last tick."""
        values, positions = self.values(state), state.poses[state.present, :2]
        return {
            "team_index": values.team_index,
            "team_index_target": values.target,
            "cutting_robots": cutting_number(state, telemetry),
            "covered_area": coverage.covered_area(positions, self.scenario.objective.minimum_separation),
            "delivery_after_loss": values.delivery,
            **self.times(),
        }

    def report(self, state: State, telemetry: Telemetry) -> dict[str, Any]:
        """The fields of a Report, at the last tick."""
        values = self.values(state)
        slots, plans = places(self.scenario, telemetry)
        return {
            "has_team_index": True,
            "team_index": values.team_index,
            "team_index_target": values.target,
            "delivery_after_loss": values.delivery,
            "cutting": cutting_robots(state, telemetry),
            "slots": slots,
            "plans": plans,
        }

    def _computed(self, state: State) -> TeamValues:
        index, wanted = index_of(state, self.scenario.objective), self._target(state)
        return TeamValues(target=wanted) if index is None else TeamValues(index.value, wanted, index.delivery)

    def _target(self, state: State) -> float:
        channel, robots = state.channel, int(np.count_nonzero(state.present))
        if channel is not self._channel:
            self._channel, self._targets = channel, {}
        if robots not in self._targets:
            context = reception.context(self.scenario)
            self._targets[robots] = target(robots, self.scenario.formation, channel, context)
        return self._targets[robots]


def places(scenario: Scenario, telemetry: Telemetry) -> tuple[Ints, Ints]:
    """Slot and plan of each robot [n], from the details `slot` and `plan` of its formation law; [0] without them.

    A robot that takes no part has neither: -1 and NO_PLAN.
    """
    names = getattr(registry.load(FORMATION, chosen(scenario.formation.acting_law).use), "details", ())
    columns = [names.index(name) for name in DETAILS if isinstance(names, tuple) and name in names]
    none = np.zeros(0, dtype=np.int64)
    if len(columns) < len(DETAILS) or telemetry.details.shape[1] <= max(columns):
        return none, none
    slots, plans = telemetry.details[:, columns].T
    n = len(slots)
    is_slot = (slots >= 0) & (slots < n)
    is_plan = (plans >= 0) & (plans < NO_PLAN)
    return np.where(is_slot, slots, -1).astype(np.int64), np.where(is_plan, plans, NO_PLAN).astype(np.int64)


def index_of(state: State, objective: ObjectiveConfig) -> TeamIndex | None:
    """The team index of the robots present; None for fewer than two, and for more than `team_index.MAX_ROBOTS`."""
    if np.count_nonzero(state.present) > MAX_ROBOTS:  # their matrix of links would be large
        return None
    return team_index(state.poses[state.present, :2], delivery.links_of(state, objective), objective)


def cutting_robots(state: State, telemetry: Telemetry) -> Ints:
    """Ids of the robots present whose loss would cut the links in use between the others, ascending [k]."""
    return graphs.cut_rows(len(state.poses), *links_between(state, telemetry))


def cutting_number(state: State, telemetry: Telemetry) -> int | None:
    """Number of these robots; None if the links in use do not connect the robots present."""
    is_cut = graphs.parts(state.present, *links_between(state, telemetry)) > 1
    return None if is_cut else len(cutting_robots(state, telemetry))


def links_between(state: State, telemetry: Telemetry) -> tuple[Ints, Ints]:
    """Both ends of each link in use between robots that are present [l]."""
    links = telemetry.links
    undirected = links.undirected
    a, b = links.rows[undirected], links.peers[undirected]
    both = state.present[a] & state.present[b]
    return a[both], b[both]
