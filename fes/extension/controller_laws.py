"""The laws of a crew of controllers: one steps them, the other publishes their estimates.

The links are those of the neighbor rule.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from fes.arithmetic import elementary
from fes.arrays import geometry
from fes.arrays.edges import Edges, no_edges
from fes.arrays.types import Bools, Floats
from fes.extension.checked import Checked
from fes.extension.context import LawContext
from fes.extension.controllers import Action, ControllerContext, Neighbor, Pull, RobotView, Twist
from fes.extension.neighborhood import Entry, LinkGeometry, Neighborhood
from fes.extension.protocols import Formed, NoParameters, Published
from fes.model.sensing import MAX_STATISTICS
from fes.model.table import Table


@dataclass(frozen=True, eq=False)
class ControllerState:
    """The controllers of a crew, and what they told at the last tick."""

    controllers: tuple[Any, ...]
    links: Edges
    estimates: Floats
    """[l] [m]"""
    statistics: Floats
    """[n, q]"""


class ControllerFormation:
    """The formation law of a crew of controllers: it steps them."""

    Parameters = NoParameters
    declared = 0
    details: tuple[str, ...] = ()

    def __init__(self, controller: Any, parameters: Table, context: LawContext, name: str) -> None:
        self._checked = Checked(controller, name)
        self._statistics = self._checked.number("statistics", MAX_STATISTICS)
        self._class, self._parameters, self._context = controller, parameters, context
        self._own_ids = context.draws.own_ids(context.ids).tolist()

    def start(self) -> ControllerState:
        """A new controller for each robot."""
        n = len(self._own_ids)
        controllers = tuple(map(self._new, range(n)))
        return ControllerState(controllers, no_edges(self._context.ids), np.zeros(0), np.zeros((n, self._statistics)))

    def forget(self, state: ControllerState, restarted: Bools) -> ControllerState:
        """New controllers for the robots `restarted` [n]."""
        controllers = tuple(
            self._new(row) if is_new else controller
            for row, (controller, is_new) in enumerate(zip(state.controllers, restarted.tolist(), strict=True))
        )
        return ControllerState(controllers, state.links, state.estimates, state.statistics)

    def step(self, state: ControllerState, around: Neighborhood, links: LinkGeometry) -> Formed:
        """The moves of all robots."""
        n, statistics = len(state.controllers), np.zeros_like(state.statistics)
        pull, twists, estimates = np.zeros((n, 2)), np.full((n, 2), np.nan), links.separation.copy()
        neighbors, spans = self._neighbors(around), around.links.spans
        linked = self._context.draws.own_ids(around.links.peers).tolist()
        poses = around.poses.tolist()
        for row, controller in enumerate(state.controllers):
            x, y, heading = poses[row]
            seen = tuple(neighbors[row])
            action = self._action(
                controller, RobotView(self._own_ids[row], around.tick, around.dt, x, y, heading, seen)
            )
            (twists if isinstance(action.move, Twist) else pull)[row] = action.move
            if len(action.statistics):
                statistics[row] = action.statistics
            for position in range(spans[row].start, spans[row].stop):
                estimates[position] = action.estimates.get(linked[position], estimates[position])
        after = ControllerState(state.controllers, around.links, estimates, statistics)
        return Formed(after, pull, twists=twists)

    def _new(self, row: int) -> Any:
        context = self._context
        own = ControllerContext(self._own_ids[row], context.dt, context.objective, context, int(context.ids[row]))
        return self._checked.call(self._class, self._parameters, own)

    def _action(self, controller: Any, robot: RobotView) -> Action:
        """The action of a controller, checked; raises FesError in one line."""
        result = self._checked.call(controller.step, robot)
        action = result if isinstance(result, Action) else Action(result)
        if not isinstance(action.move, Twist | Pull):
            self._checked.fail(f"step must return a Twist, a Pull or an Action, got {type(result).__name__}")
        try:
            count, numbers = len(action.statistics), [*action.move, *action.estimates.values(), *action.statistics]
            is_finite = all(map(math.isfinite, numbers))
        except (TypeError, AttributeError, OverflowError):
            self._checked.fail(f"step must return numbers, estimates by id and a list of statistics, got {action}")
        if count not in (0, self._statistics):
            self._checked.fail(f"step must return {self._statistics} statistics, got {count}")
        if not is_finite:
            self._checked.fail(f"step must return finite numbers, got {action} at tick {robot.tick}")
        return action

    def _neighbors(self, around: Neighborhood) -> list[list[Neighbor]]:
        """The neighbors of each robot."""
        contacts = around.contacts
        edges = contacts.edges
        headings = around.poses[:, geometry.HEADING].take(edges.rows)
        bearing = geometry.wrap(elementary.atan2(contacts.dy, contacts.dx) - headings)
        age = around.dt * (around.tick - contacts.heard).astype(np.float64)
        columns = (
            self._context.draws.own_ids(edges.peers),
            contacts.x,
            contacts.y,
            contacts.heading,
            contacts.separation,
            contacts.dx,
            contacts.dy,
            bearing,
            age,
            contacts.estimates,
        )
        result: list[list[Neighbor]] = [[] for _ in edges.ids]
        rows = zip(*(column.tolist() for column in columns), strict=True)
        numbers, known, robots = contacts.statistics.tolist(), contacts.known.tolist(), edges.rows.tolist()
        for (*seen, estimate), statistics, is_known, row in zip(rows, numbers, known, robots, strict=True):
            if is_known:
                own = None if math.isnan(estimate) else estimate
                result[row].append(Neighbor._make((*seen, own, tuple(statistics))))
        return result


class ControllerSeeking:
    """The seeking law beside `ControllerFormation`: it publishes what the controllers told."""

    Parameters = NoParameters
    knows_channel = False
    declared = 0
    learnt: tuple[str, ...] = ()

    def __init__(self, controller: Any, context: LawContext) -> None:
        self.statistics = int(getattr(controller, "statistics", 0))
        self._n = len(context.ids)

    def start(self) -> ControllerState | None:
        """No controller was stepped yet."""
        return None

    def forget(
        self, state: ControllerState | None, restarted: Bools, old: Edges, new: Edges
    ) -> ControllerState | None:
        """Unchanged: the state is replaced at each tick."""
        return state

    def relink(self, state: ControllerState | None, old: Edges, new: Edges, entry: Entry) -> ControllerState | None:
        """Unchanged: the state is replaced at each tick."""
        return state

    def desired(self, state: ControllerState | None, tick: int, links: Edges) -> Floats:
        """No separation is asked for: a controller moves by itself [l] [m]."""
        return np.full(len(links), np.nan)

    def measure(self, state: ControllerState | None, around: Neighborhood, formed: Formed) -> ControllerState:
        """The values that the controllers gave at this tick."""
        given: ControllerState = formed.state
        return given

    def publish(self, state: ControllerState | None, links: Edges) -> Published:
        """The estimates and the statistics of the controllers."""
        assert state is not None
        return Published(state.estimates, state.statistics, np.zeros((0, len(links))))

    def seek(self, state: ControllerState, around: Neighborhood) -> ControllerState:
        """Unchanged: a controller seeks in its own step."""
        return state
