"""A package of another project, with one extension of each kind, written with the public interface only."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from fes.extension import (
    Action,
    Bools,
    Contacts,
    ControllerContext,
    Edges,
    Entry,
    Floats,
    Formed,
    LawContext,
    LinkGeometry,
    Neighborhood,
    NoParameters,
    Published,
    Pull,
    RobotView,
    Table,
    WorldContext,
)


class Target(Table):
    """A separation, and the share of the error that a robot corrects."""

    target: float = 68.0
    """[m]"""
    gain: float = 0.4


class Near:
    """Selects the peers within 100 m."""

    Parameters = NoParameters

    def __init__(self, parameters: NoParameters, context: LawContext) -> None: ...

    def __call__(self, contacts: Contacts) -> Bools:
        return contacts.known & (contacts.separation < 100.0)


class Formation:
    """Corrects a share of each link's error; declares the tick, and shows the length of the pull."""

    Parameters = Target
    declared = 4
    details = ("pull_length",)

    def __init__(self, parameters: Target, context: LawContext) -> None:
        self.gain, self.n = parameters.gain, len(context.ids)

    def start(self) -> Floats:
        return np.zeros(self.n)

    def forget(self, state: Floats, restarted: Bools) -> Floats:
        return np.where(restarted, 0.0, state)

    def step(self, state: Floats, around: Neighborhood, links: LinkGeometry) -> Formed:
        x, y = self.gain * links.error * links.bearing
        pull = np.stack([around.links.sum(x), around.links.sum(y)], axis=1)
        declared = np.full((self.n, 4), around.tick % 200, dtype=np.uint8)
        return Formed(state + 1.0, pull, declared, np.hypot(*pull.T)[:, None])


class Seeking:
    """Approaches the target, with noise; counts nothing."""

    Parameters = Target
    knows_channel = False
    statistics = 1
    declared = 0
    learnt = ("one",)

    def __init__(self, parameters: Target, context: LawContext) -> None:
        self.target, self.context = parameters.target, context

    def start(self) -> Floats:
        return np.zeros(0)

    def forget(self, state: Floats, restarted: Bools, old: Edges, new: Edges) -> Floats:
        return new.carry(state, old, 0.0)

    def relink(self, state: Floats, old: Edges, new: Edges, entry: Entry) -> Floats:
        return new.carry(state, old, 90.0)

    def desired(self, state: Floats, tick: int, links: Edges) -> Floats:
        return state

    def measure(self, state: Floats, around: Neighborhood, formed: Formed) -> Floats:
        return state

    def publish(self, state: Floats, links: Edges) -> Published:
        return Published(state, np.ones((len(self.context.ids), 1)), np.ones((1, len(links))))

    def seek(self, state: Floats, around: Neighborhood) -> Floats:
        noise = self.context.draws(f"noise {around.tick}", around.links.robots, around.links.peers)
        return state + 0.01 * (self.target - state) + 0.001 * noise


class Controller:
    """Goes to the target separation from its neighbors, and counts its steps."""

    Parameters = Target
    statistics = 1

    def __init__(self, parameters: Target, context: ControllerContext) -> None:
        self.parameters, self.context, self.steps = parameters, context, 0

    def step(self, robot: RobotView) -> Action:
        self.steps += 1
        shares = [(peer, 1.0 - self.parameters.target / peer.separation) for peer in robot.neighbors]
        x = sum(peer.dx * share for peer, share in shares) + 0.01 * self.context.draw(f"noise {robot.tick}")
        y = sum(peer.dy * share for peer, share in shares)
        move = Pull(self.parameters.gain * x, self.parameters.gain * y)
        return Action(move, {peer.id: self.parameters.target for peer in robot.neighbors}, (float(self.steps),))


class Gaussian:
    """Reception falls as a Gaussian of the separation."""

    Parameters = NoParameters

    def __init__(self, parameters: NoParameters, context: WorldContext) -> None: ...

    def probability(self, separation: Floats) -> Floats:
        probability: Floats = np.exp(-((separation / 120.0) ** 2))
        return probability


class Moving(NamedTuple):
    """Bodies with motors."""

    poses: Floats
    twists: Floats


class SlowMotors:
    """Motors follow their commands with a delay of a few ticks."""

    Parameters = NoParameters

    def __init__(self, parameters: NoParameters, context: WorldContext) -> None: ...

    def start(self, poses: Floats) -> Moving:
        return Moving(poses, np.zeros((len(poses), 2)))

    def step(self, state: Moving, twists: Floats, dt: float) -> Moving:
        held = state.twists + 0.2 * (twists - state.twists)
        x, y, heading = state.poses.T
        cosine, sine = np.cos(heading), np.sin(heading)
        moved = (x + dt * held[:, 0] * cosine, y + dt * held[:, 0] * sine, heading + dt * held[:, 1])
        return Moving(np.stack(moved, axis=1), held)

    def poses(self, state: Moving) -> Floats:
        return state.poses


class Effort:
    """The sum of all squared speeds."""

    Parameters = NoParameters

    def __init__(self, parameters: NoParameters, context: WorldContext) -> None:
        self.total = 0.0

    def add(self, tick: Any) -> None:
        self.total += float((tick.twists[:, 0] ** 2).sum())

    def result(self) -> Mapping[str, float | None]:
        return {"total": self.total}
