"""What changes while a run goes on: scheduled by the scenario, or set from another terminal."""

from collections.abc import Iterable
from typing import Annotated, Any, NamedTuple, Self

import numpy as np
from pydantic import Field, ValidationError, model_validator

from fes.arrays import Bools
from fes.config import Table
from fes.errors import ScenarioError
from world.radio_config import RadioConfig
from world.rules import first_rule

PREFIX = "channel."
"""What can be changed: the rest is what the robots were told when they joined."""


RobotId = Annotated[int, Field(ge=0)]


class EventConfig(Table):
    """What happens at one time."""

    at: Annotated[float, Field(ge=0, le=1e9)]
    """[s]; it acts from the tick nearest to it on."""
    settings: dict[str, Any] = Field(default={}, alias="set")
    """Field of the channel, by its dotted path -> its new value."""
    kill: list[RobotId] = Field(default=[])
    """Robots whose processes die: their bodies stop, their radios are silent."""
    restart: list[RobotId] = Field(default=[])
    """Robots that come back, where they are, knowing nothing."""

    @model_validator(mode="after")
    def _something(self) -> Self:
        if not (self.settings or self.kill or self.restart):
            raise ValueError("give at least one of set, kill and restart")
        if set(self.kill) & set(self.restart):
            raise ValueError(f"robot {min(set(self.kill) & set(self.restart))} cannot both be killed and restarted")
        return self


def changed(channel: RadioConfig, settings: dict[str, Any], dt: float) -> RadioConfig:
    """The channel with `settings`, by dotted path; raises ScenarioError in one line."""
    tables = channel.model_dump()
    for path, value in settings.items():
        if value is None:
            raise ScenarioError(path, "cannot be nothing: a deviation or a loss of 0 takes shadowing or bursts away")
        if not path.startswith(PREFIX):
            raise ScenarioError(path, f"only fields like '{PREFIX}reference_snr' can be changed while a run goes on")
        *parents, field = path.removeprefix(PREFIX).split(".")
        table = tables
        for parent in parents:
            if table.get(parent) is None:
                table[parent] = {}
            table = table[parent]
            if not isinstance(table, dict):
                raise ScenarioError(path, f"goes through '{parent}', which is not a table")
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
    """Who dies and who comes back at a tick."""

    gone: Bools
    """[n]"""
    back: Bools
    """[n]"""


def attended(present: Bools, planned: Planned) -> Bools:
    """Who is present [n] after that."""
    after: Bools = (present & ~planned.gone) | planned.back
    return after


def attendance(events: Iterable[EventConfig], robots: int, dt: float) -> dict[int, Planned]:
    """Tick -> who dies and who comes back, in order; raises ScenarioError in one line."""
    present, found = np.ones(robots, dtype=np.bool_), dict[int, Planned]()
    for event in sorted((event for event in events if event.kill or event.restart), key=lambda event: event.at):
        nobody = np.zeros(robots, dtype=np.bool_)
        planned = found.setdefault(round(event.at / dt), Planned(nobody, nobody.copy()))
        for verb, named, alive in (("kill", event.kill, True), ("restart", event.restart, False)):
            for robot in named:
                if robot >= robots:
                    raise ScenarioError("event", f"{verb}: robot {robot} does not exist, there are {robots}")
                if present[robot] != alive:
                    state = "dead" if alive else "alive"
                    raise ScenarioError("event", f"{verb}: robot {robot} is {state} already at {event.at:g} s")
                if planned.gone[robot] or planned.back[robot]:
                    raise ScenarioError("event", f"{verb}: robot {robot} dies and comes back in one tick")
                present[robot] = not alive
                (planned.gone if alive else planned.back)[robot] = True
    return found


def schedule(events: Iterable[EventConfig], dt: float) -> dict[int, dict[str, Any]]:
    """Tick -> what is set from it on; of two events of one tick the later one in the file wins."""
    found: dict[int, dict[str, Any]] = {}
    for event in events:
        if not event.settings:
            continue
        here = found.setdefault(round(event.at / dt), {})
        for path, value in event.settings.items():
            here.pop(path, None)  # what is set again comes last
            here[path] = value
    return dict(sorted(found.items()))
