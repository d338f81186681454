"""What changes while a run goes on: scheduled by the scenario, or set from another terminal."""

import reprlib
from collections.abc import Iterable
from typing import Any

from pydantic import Field, ValidationError

from fes.config import NonNegative, Table
from fes.errors import ScenarioError
from world.radio_config import RadioConfig

PREFIX = "channel."
"""What can be changed: the rest is what the robots were told when they joined."""


class EventConfig(Table):
    """One change at one time."""

    at: NonNegative
    """[s]; it acts from the tick nearest to it on."""
    settings: dict[str, Any] = Field(alias="set", min_length=1)
    """Field of the channel, by its dotted path -> its new value."""


def changed(channel: RadioConfig, settings: dict[str, Any], dt: float) -> RadioConfig:
    """The channel with `settings`, by dotted path; raises ScenarioError in one line."""
    tables = channel.model_dump()
    for path, value in settings.items():
        if not path.startswith(PREFIX):
            raise ScenarioError(path, f"only {PREFIX}* can be changed while a run goes on")
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
        first = error.errors(include_url=False)[0]
        field = PREFIX + ".".join(str(part) for part in first["loc"])
        if first["type"] == "extra_forbidden":
            raise ScenarioError(field, "the channel has no such field") from None
        message = first["msg"].removeprefix("Value error, ").replace("Input should be", "must be")
        raise ScenarioError(field, f"{message}, got {reprlib.repr(first['input'])}") from None
    except ValueError as error:
        raise ScenarioError(next(iter(settings)), str(error)) from None
    return result


def effective(channel: RadioConfig, path: str) -> Any:
    """The value of a field of the channel by its dotted path."""
    found: Any = channel.model_dump(mode="json")
    for part in path.removeprefix(PREFIX).split("."):
        found = found[part]
    return found


def schedule(events: Iterable[EventConfig], dt: float) -> dict[int, dict[str, Any]]:
    """Tick -> what is set from it on; of two events of one tick the later one in the file wins."""
    found: dict[int, dict[str, Any]] = {}
    for event in events:
        found.setdefault(round(event.at / dt), {}).update(event.settings)
    return dict(sorted(found.items()))
