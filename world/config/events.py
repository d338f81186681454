"""Changes during a run: the events of a scenario, and changes set from another terminal."""

from collections.abc import Iterable
from typing import Annotated, Any, NamedTuple, Self

import numpy as np
from pydantic import Field, ValidationError, model_validator

from fes.arrays.types import Bools
from fes.errors import ScenarioError
from fes.model import counts
from fes.model.table import Table
from fes.settings.validation import first_rule, short
from world.config import faults
from world.config.faults import ClockConfig, Part, RobotId, TransmitterConfig
from world.config.overrides import descend, value_at
from world.config.radio import RadioConfig

PREFIX = "channel."
"""Prefix of the fields that can change: robots receive the other settings only when they join."""


class EventConfig(Table):
    """Changes at one time."""

    at: Annotated[float, Field(ge=0, le=1e9)]
    """Simulated time of the event [s]; it acts at the nearest tick."""
    settings: dict[str, Any] = Field(default={}, alias="set")
    """New values of fields of the channel, by dotted path, such as `channel.reference_snr`."""
    kill: list[RobotId] = Field(default=[])
    """Ids of robots whose processes die: their bodies stop, and their radios are silent."""
    restart: list[RobotId] = Field(default=[])
    """Ids of dead robots whose processes restart: they start at their present poses, without state."""
    hang: list[RobotId] = Field(default=[])
    """Ids of robots whose processes are suspended; their peers cannot tell them from dead robots."""
    wake: list[RobotId] = Field(default=[])
    """Ids of hung robots whose processes continue; the robots rejoin."""
    transmitter: TransmitterConfig | None = None
    """New condition of a robot's transmitter."""
    clock: ClockConfig | None = None
    """New skew of a robot's clock."""
    world_away: Annotated[float, Field(gt=0, le=10)] | None = None
    """Time for which the world's process is dead, until another one resumes the run [s; wall clock]; simulated time
    stands still."""

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        acts = (self.settings, self.parts, self.world_away, any(robots for _, robots in self.verbs))
        if not any(acts):
            raise ValueError("give at least one of set, kill, restart, hang, wake, transmitter, clock and world_away")
        seen: dict[int, str] = {}
        for verb, robots in self.verbs:
            for robot in robots:
                if robot in seen:
                    raise ValueError(f"robot {robot} must be named once, but is in {seen[robot]} and in {verb}")
                seen[robot] = verb
        return self

    @property
    def verbs(self) -> list[tuple[str, list[int]]]:
        """Robots that die, hang, restart and wake, by the key of the event."""
        return [("kill", self.kill), ("hang", self.hang), ("restart", self.restart), ("wake", self.wake)]

    @property
    def parts(self) -> list[Part]:
        """New conditions of transmitters and clocks."""
        return [part for part in (self.transmitter, self.clock) if part is not None]


def changed(channel: RadioConfig, settings: dict[str, Any], dt: float) -> RadioConfig:
    """The channel with `settings`, by dotted path; raises ScenarioError in one line."""
    tables = channel.model_dump()
    for path, value in settings.items():
        if value is None:
            raise ScenarioError(
                short(path), "cannot be null: to remove shadowing or bursts, set a deviation or a loss of 0"
            )
        if not path.startswith(PREFIX):
            raise ScenarioError(short(path), f"only fields like '{PREFIX}reference_snr' can change during a run")
        *parents, field = path.removeprefix(PREFIX).split(".")
        table = tables
        for parent in parents:
            table = descend(table, parent)
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
    """The value of a field of the channel, by its dotted path."""
    return value_at(channel.model_dump(mode="json"), path.removeprefix(PREFIX))


class ParticipationChange(NamedTuple):
    """Robots that leave and rejoin at a tick by schedule."""

    gone: Bools
    """True for a robot that dies or hangs [n]."""
    back: Bools
    """True for a robot that restarts or wakes [n]."""
    hung: Bools
    """True for a robot that hangs: its process still exists [n]."""


def participating(present: Bools, change: ParticipationChange) -> Bools:
    """Robots present after a change [n]."""
    after: Bools = (present & ~change.gone) | change.back
    return after


_BECOMES = {
    "kill": ("alive", "dead"),
    "hang": ("alive", "hung"),
    "restart": ("dead", "alive"),
    "wake": ("hung", "alive"),
}
"""Key of an event -> the state of a robot that it requires, and the state that follows."""


def participation(events: Iterable[EventConfig], robots: int, dt: float) -> dict[int, ParticipationChange]:
    """Tick -> change of participation, in order; raises ScenarioError in one line."""
    states, changes = ["alive"] * robots, dict[int, ParticipationChange]()
    for event in sorted(events, key=lambda event: event.at):
        for verb, selected in event.verbs:
            before, after = _BECOMES[verb]
            for robot in selected:
                if robot >= robots:
                    raise ScenarioError("event", f"{verb}: robot {robot} does not exist: there are only {robots}")
                if states[robot] != before:
                    state = states[robot] + (" already" if states[robot] == after else "")
                    raise ScenarioError("event", f"{verb}: robot {robot} is {state} at {event.at:g} s")
                tick = counts.ticks(event.at, dt)
                change = changes.setdefault(tick, _no_change(robots))
                if change.gone[robot] or change.back[robot]:
                    raise ScenarioError("event", f"{verb}: robot {robot} leaves and rejoins in one tick")
                states[robot] = after
                if after == "alive":
                    change.back[robot] = True
                else:
                    change.gone[robot] = True
                change.hung[robot] = after == "hung"
    return changes


def _no_change(robots: int) -> ParticipationChange:
    return ParticipationChange(*(np.zeros(robots, dtype=np.bool_) for _ in ParticipationChange._fields))


def parts(events: Iterable[EventConfig], robots: int, dt: float) -> list[tuple[int, Part]]:
    """New conditions of transmitters and clocks, with their ticks, in order; raises ScenarioError in one line."""
    timed = [(counts.ticks(event.at, dt), part) for event in events for part in event.parts]
    for _, part in timed:
        faults.check(part, robots, dt)
    return sorted(timed, key=lambda entry: entry[0])


def schedule(events: Iterable[EventConfig], dt: float) -> dict[int, dict[str, Any]]:
    """Tick -> settings of the channel from that tick on. Of two events at a tick, the later one in the file wins."""
    settings: dict[int, dict[str, Any]] = {}
    for event in events:
        if not event.settings:
            continue
        at_tick = settings.setdefault(counts.ticks(event.at, dt), {})
        for path, value in event.settings.items():
            at_tick.pop(path, None)  # a field that is set again goes last
            at_tick[path] = value
    return dict(sorted(settings.items()))
