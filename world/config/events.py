"""What changes while a run goes on: scheduled by the scenario, or set from another terminal."""

from collections.abc import Iterable
from typing import Annotated, Any, NamedTuple, Self

import numpy as np
from pydantic import Field, ValidationError, model_validator

from fes.arrays.types import Bools
from fes.errors import ScenarioError
from fes.model import counts
from fes.model.config import Table
from world.config import faults
from world.config.faults import ClockConfig, Part, RobotId, TransmitterConfig
from world.config.radio import RadioConfig
from world.config.validation import first_rule, short

PREFIX = "channel."
"""What can be changed: the rest is what the robots were told when they joined."""


class EventConfig(Table):
    """What happens at one time."""

    at: Annotated[float, Field(ge=0, le=1e9)]
    """Simulated time of the event [s]; it acts from the nearest tick on."""
    settings: dict[str, Any] = Field(default={}, alias="set")
    """Field of the channel, by its dotted path -> its new value."""
    kill: list[RobotId] = Field(default=[])
    """Robots whose processes die: their bodies stop, their radios are silent."""
    restart: list[RobotId] = Field(default=[])
    """Robots that come back, where they are, knowing nothing."""
    hang: list[RobotId] = Field(default=[])
    """Robots whose processes stop without dying; for the others it is the same."""
    wake: list[RobotId] = Field(default=[])
    """Robots whose processes go on; for the others they come back."""
    transmitter: TransmitterConfig | None = None
    """New condition of a robot's transmitter."""
    clock: ClockConfig | None = None
    """New skew of a robot's clock."""
    world_away: Annotated[float, Field(gt=0, le=10)] | None = None
    """The world's process dies, and another goes on after so long [s; wall clock]. It moves nothing: simulated time
    stands still."""

    @model_validator(mode="after")
    def _something(self) -> Self:
        acts = (self.settings, self.parts, self.world_away, any(robots for _, robots in self.verbs))
        if not any(acts):
            raise ValueError("give at least one of set, kill, restart, hang, wake, transmitter, clock and world_away")
        seen: dict[int, str] = {}
        for verb, robots in self.verbs:
            for robot in robots:
                if robot in seen:
                    raise ValueError(f"robot {robot} is named in {seen[robot]} and in {verb}: once is enough")
                seen[robot] = verb
        return self

    @property
    def verbs(self) -> list[tuple[str, list[int]]]:
        """Who dies, hangs and comes back."""
        return [("kill", self.kill), ("hang", self.hang), ("restart", self.restart), ("wake", self.wake)]

    @property
    def parts(self) -> list[Part]:
        """What becomes of robots' equipment."""
        return [part for part in (self.transmitter, self.clock) if part is not None]


def changed(channel: RadioConfig, settings: dict[str, Any], dt: float) -> RadioConfig:
    """The channel with `settings`, by dotted path; raises ScenarioError in one line."""
    tables = channel.model_dump()
    for path, value in settings.items():
        if value is None:
            raise ScenarioError(
                short(path), "cannot be nothing: a deviation or a loss of 0 takes shadowing or bursts away"
            )
        if not path.startswith(PREFIX):
            raise ScenarioError(
                short(path), f"only fields like '{PREFIX}reference_snr' can be changed while a run goes on"
            )
        *parents, field = path.removeprefix(PREFIX).split(".")
        table = tables
        for parent in parents:
            if table.get(parent) is None:
                table[parent] = {}
            table = table[parent]
            if not isinstance(table, dict):
                raise ScenarioError(short(path), f"goes through '{short(parent)}', which is not a table")
        table[field] = value
    try:
        result = RadioConfig.model_validate(tables)
        result.check(dt)
    except ValidationError as error:
        rule = first_rule(error, RadioConfig, "channel", PREFIX)
        raise ScenarioError("the channel", rule) from None
    except ValueError as error:
        raise ScenarioError("the channel", str(error)) from None
    return result


def effective(channel: RadioConfig, path: str) -> Any:
    """The value of a field of the channel by its dotted path."""
    found: Any = channel.model_dump(mode="json")
    for part in path.removeprefix(PREFIX).split("."):
        found = found[part]
    return found


class Planned(NamedTuple):
    """Who goes and who comes back at a tick."""

    gone: Bools
    """Who dies or hangs [n]."""
    back: Bools
    """Who is restarted or wakes [n]."""
    hung: Bools
    """Of those gone, who hangs: its process is there [n]."""


def attended(present: Bools, planned: Planned) -> Bools:
    """Who is present [n] after that."""
    after: Bools = (present & ~planned.gone) | planned.back
    return after


_BECOMES = {
    "kill": ("alive", "dead"),
    "hang": ("alive", "hung"),
    "restart": ("dead", "alive"),
    "wake": ("hung", "alive"),
}
"""What a robot must be, and what it then is."""


def attendance(events: Iterable[EventConfig], robots: int, dt: float) -> dict[int, Planned]:
    """Tick -> who goes and who comes back, in order; raises ScenarioError in one line."""
    states, found = ["alive"] * robots, dict[int, Planned]()
    for event in sorted(events, key=lambda event: event.at):
        for verb, named in event.verbs:
            before, after = _BECOMES[verb]
            for robot in named:
                if robot >= robots:
                    raise ScenarioError("event", f"{verb}: robot {robot} does not exist, there are {robots}")
                if states[robot] != before:
                    state = states[robot] + (" already" if states[robot] == after else "")
                    raise ScenarioError("event", f"{verb}: robot {robot} is {state} at {event.at:g} s")
                tick = counts.ticks(event.at, dt)
                if tick not in found:
                    found[tick] = Planned(*(np.zeros(robots, dtype=np.bool_) for _ in Planned._fields))
                planned = found[tick]
                if planned.gone[robot] or planned.back[robot]:
                    raise ScenarioError("event", f"{verb}: robot {robot} goes and comes back in one tick")
                states[robot] = after
                (planned.back if after == "alive" else planned.gone)[robot] = True
                planned.hung[robot] = after == "hung"
    return found


def parts(events: Iterable[EventConfig], robots: int, dt: float) -> list[tuple[int, Part]]:
    """What becomes of robots' equipment, with its tick, in order; raises ScenarioError in one line."""
    found = [(counts.ticks(event.at, dt), part) for event in events for part in event.parts]
    for _, part in found:
        faults.check(part, robots, dt)
    return sorted(found, key=lambda one: one[0])


def schedule(events: Iterable[EventConfig], dt: float) -> dict[int, dict[str, Any]]:
    """Tick -> what is set from it on; of two events of one tick the later one in the file wins."""
    found: dict[int, dict[str, Any]] = {}
    for event in events:
        if not event.settings:
            continue
        here = found.setdefault(counts.ticks(event.at, dt), {})
        for path, value in event.settings.items():
            here.pop(path, None)  # what is set again comes last
            here[path] = value
    return dict(sorted(found.items()))
