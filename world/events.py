"""What changes while a run goes on: scheduled by the scenario, or set from another terminal."""

from collections.abc import Iterable
from typing import Annotated, Any

from pydantic import Field, ValidationError

from fes.config import Table
from fes.errors import ScenarioError
from world.radio_config import RadioConfig
from world.rules import first_rule

PREFIX = "channel."
"""What can be changed: the rest is what the robots were told when they joined."""


class EventConfig(Table):
    """One change at one time."""

    at: Annotated[float, Field(ge=0, le=1e9)]
    """[s]; it acts from the tick nearest to it on."""
    settings: dict[str, Any] = Field(alias="set", min_length=1)
    """Field of the channel, by its dotted path -> its new value."""


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


def schedule(events: Iterable[EventConfig], dt: float) -> dict[int, dict[str, Any]]:
    """Tick -> what is set from it on; of two events of one tick the later one in the file wins."""
    found: dict[int, dict[str, Any]] = {}
    for event in events:
        here = found.setdefault(round(event.at / dt), {})
        for path, value in event.settings.items():
            here.pop(path, None)  # what is set again comes last
            here[path] = value
    return dict(sorted(found.items()))
