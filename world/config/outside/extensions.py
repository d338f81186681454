"""The extensions of a scenario, and whether they are those of a recorded run."""

from typing import Any

from fes.errors import FesError
from fes.extension import evidence
from fes.extension.evidence import Evidence
from fes.extension.kinds import CHANNEL, Kind
from fes.model.table import chosen
from world.config.scenario import Scenario


def of(scenario: Scenario) -> list[Evidence]:
    """The evidence of all extensions that a scenario chooses at any time, built-in ones aside; raises FesError."""
    kinds: dict[tuple[str, str], Kind] = {}
    later = [settings["channel.model"] for settings in scenario.changes.values() if "channel.model" in settings]
    choices = [(kind, choice) for _, kind, choice in scenario.choices] + [(CHANNEL, choice) for choice in later]
    for kind, choice in choices:
        name = choice["use"] if isinstance(choice, dict) else chosen(choice).use
        if name not in kind.built_in:
            kinds[kind.name, name] = kind
    return [evidence.of(kind, name) for (_, name), kind in kinds.items()]


def check(scenario: Scenario, recorded: list[Any], where: str) -> None:
    """Raise FesError in one line unless the extensions of a scenario are those `recorded` at `where`."""
    before = {(entry["kind"], entry["name"]): entry for entry in recorded}
    for now in of(scenario):
        known = before.get((now.kind, now.name))
        difference = evidence.difference(known, now) if known else f"{now.kind} '{now.name}' was not recorded"
        if difference:
            raise FesError(f"{where}: {difference}")
