"""Faults of robots' transmitters and clocks: those that the world emulates, and those that the agents emulate."""

from collections.abc import Iterable
from typing import Annotated, NamedTuple

import numpy as np
from pydantic import Field

from fes.arrays.types import Bools, Floats
from fes.errors import ScenarioError
from fes.model import counts
from fes.model.config import MAX_DELAY, MAX_SKEW, FaultConfig
from fes.model.table import Table

RobotId = Annotated[int, Field(ge=0)]


class TransmitterConfig(Table):
    """Complete condition of a robot's transmitter from a tick on; an absent key means that the fault is absent."""

    robot: RobotId
    """Id of the robot."""
    loss: Annotated[float, Field(ge=0, le=1)] = 0.0
    """Share of its beacons that are lost at every receiver, in addition to the losses of the channel [1]."""
    delay: Annotated[float, Field(ge=0, allow_inf_nan=False)] = 0.0
    """Age of the data in its beacons, which carry the present tick [s]; a whole number of ticks."""
    corrupt: bool = False
    """True if its beacons are damaged in transit: none decodes."""


class ClockConfig(Table):
    """Skew of a robot's clock from a tick on."""

    robot: RobotId
    """Id of the robot."""
    skew: Annotated[float, Field(ge=-MAX_SKEW, le=MAX_SKEW)] | None = None
    """Skew, positive if the clock is ahead of the team's [s]; by default the one drawn within `run.clock_skew`."""


Part = TransmitterConfig | ClockConfig
"""New condition of a part of a robot's hardware."""


class Transmission(NamedTuple):
    """Effect of all transmitters on their beacons, which the world applies."""

    reception_factor: Floats
    """Factor on the reception probability of each robot's beacons [n] [1]."""
    damaged: Bools
    """True for a robot whose beacons cannot be read [n]."""


def check(part: Part, robots: int, dt: float) -> None:
    """Raise ScenarioError in one line unless the part exists in a team of `robots`, with ticks of `dt` [s]."""
    name = "transmitter" if isinstance(part, TransmitterConfig) else "clock"
    if part.robot >= robots:
        raise ScenarioError("event", f"{name}: robot {part.robot} does not exist: there are only {robots}")
    if (
        isinstance(part, TransmitterConfig)
        and part.delay > 0.0
        and not 1 <= counts.ticks(part.delay, dt) <= MAX_DELAY
    ):
        bounds = f"0, or from run.dt to {MAX_DELAY} ticks, {dt:g} to {MAX_DELAY * dt:g} s"
        raise ScenarioError("event", f"transmitter: delay must be {bounds}, got {part.delay:g}")


def transmissions(parts: Iterable[tuple[int, Part]], robots: int) -> dict[int, Transmission | None]:
    """Tick -> effect of the transmitters from that tick on, given `parts` in order; None if all are healthy."""
    factor, damaged = np.ones(robots), np.zeros(robots, dtype=np.bool_)
    effects: dict[int, Transmission | None] = {}
    for tick, part in parts:
        if isinstance(part, TransmitterConfig):
            factor[part.robot] = 0.0 if part.corrupt else 1.0 - part.loss
            damaged[part.robot] = part.corrupt
            effects[tick] = Transmission(factor.copy(), damaged.copy()) if (factor < 1.0).any() else None
    return effects


def agent_faults(parts: Iterable[tuple[int, Part]], dt: float) -> list[FaultConfig]:
    """Faults that the agents emulate, given `parts` in order; each is a robot's complete condition."""
    now: dict[int, FaultConfig] = {}
    conditions = []
    for tick, part in parts:
        before = now.get(part.robot, FaultConfig(tick=tick, robot=part.robot))
        if isinstance(part, TransmitterConfig):
            change: dict[str, object] = {"delay": counts.ticks(part.delay, dt), "corrupt": part.corrupt}
        else:
            change = {"skew": part.skew}
        after = before.model_copy(update={"tick": tick, **change})
        if after != before.model_copy(update={"tick": tick}):  # only the world applies a loss
            conditions.append(after)
        now[part.robot] = after
    return conditions
