"""What goes wrong with robots' own transmitters and clocks: what of it the world does, and what agents are told."""

from collections.abc import Iterable
from typing import Annotated, NamedTuple

import numpy as np
from pydantic import Field

from fes.arrays.types import Bools, Floats
from fes.errors import ScenarioError
from fes.model import counts
from fes.model.config import MAX_DELAY, MAX_SKEW, FaultConfig, Table

RobotId = Annotated[int, Field(ge=0)]


class TransmitterConfig(Table):
    """The whole condition of a robot's transmitter from a tick on; what is not given is healthy."""

    robot: RobotId
    """Id of the robot."""
    loss: Annotated[float, Field(ge=0, le=1)] = 0.0
    """Share of its beacons that are lost at every receiver, whatever the channel does [1]."""
    delay: Annotated[float, Field(ge=0, allow_inf_nan=False)] = 0.0
    """It sends what it was given so long ago [s], stamped as of now; a whole number of ticks."""
    corrupt: bool = False
    """Its beacons are damaged on their way: none decodes."""


class ClockConfig(Table):
    """How a robot's clock is off from a tick on."""

    robot: RobotId
    """Id of the robot."""
    skew: Annotated[float, Field(ge=-MAX_SKEW, le=MAX_SKEW)] | None = None
    """How far it is ahead of the team's [s]; left out: as it was drawn within `run.clock_skew`."""


Part = TransmitterConfig | ClockConfig


class Transmission(NamedTuple):
    """What the robots' transmitters do to their beacons, for the world."""

    reception_factor: Floats
    """The part that they leave of the reception probability [n] [1]."""
    damaged: Bools
    """Whose beacons nobody can read [n]."""


def check(part: Part, robots: int, dt: float) -> None:
    """Raises ScenarioError in one line unless this can be in a team of so many robots, with ticks of `dt` [s]."""
    name = "transmitter" if isinstance(part, TransmitterConfig) else "clock"
    if part.robot >= robots:
        raise ScenarioError("event", f"{name}: robot {part.robot} does not exist, there are {robots}")
    if (
        isinstance(part, TransmitterConfig)
        and part.delay > 0.0
        and not 1 <= counts.ticks(part.delay, dt) <= MAX_DELAY
    ):
        bounds = f"0, or from run.dt to {MAX_DELAY} ticks, {dt:g} to {MAX_DELAY * dt:g} s"
        raise ScenarioError("event", f"transmitter: delay must be {bounds}, got {part.delay:g}")


def transmissions(parts: Iterable[tuple[int, Part]], robots: int) -> dict[int, Transmission | None]:
    """Tick -> what holds from it on, of `parts` by tick, in order; None where all transmitters are healthy."""
    kept, damaged = np.ones(robots), np.zeros(robots, dtype=np.bool_)
    found: dict[int, Transmission | None] = {}
    for tick, part in parts:
        if isinstance(part, TransmitterConfig):
            kept[part.robot] = 0.0 if part.corrupt else 1.0 - part.loss
            damaged[part.robot] = part.corrupt
            found[tick] = Transmission(kept.copy(), damaged.copy()) if (kept < 1.0).any() else None
    return found


def told(parts: Iterable[tuple[int, Part]], dt: float) -> list[FaultConfig]:
    """What the robots' own equipment does, of `parts` by tick, in order; each is a whole condition from then on."""
    now: dict[int, FaultConfig] = {}
    found = []
    for tick, part in parts:
        before = now.get(part.robot, FaultConfig(tick=tick, robot=part.robot))
        if isinstance(part, TransmitterConfig):
            change: dict[str, object] = {"delay": counts.ticks(part.delay, dt), "corrupt": part.corrupt}
        else:
            change = {"skew": part.skew}
        after = before.model_copy(update={"tick": tick, **change})
        if after != before.model_copy(update={"tick": tick}):  # a loss is the world's alone
            found.append(after)
        now[part.robot] = after
    return found
