"""The extensions of a scenario, and whether they are those of a recorded run."""

from typing import Any

from fes.errors import FesError
from fes.extension import evidence, registry
from fes.extension.evidence import Evidence
from fes.extension.kinds import KINDS, Kind
from fes.model.table import chosen
from world.config.scenario import Scenario

_KIND = {kind.name: kind for kind in KINDS}


def of(scenario: Scenario) -> list[Evidence]:
    """The evidence of all extensions that a scenario chooses at any time, built-in ones aside; raises FesError."""
    kinds: dict[tuple[str, str], Kind] = {}
    for _, kind, choice in scenario.choices:
        name = chosen(choice).use
        if name not in kind.built_in:
            kinds[kind.name, name] = kind
    return [evidence.of(kind, name, registry.load(kind, name)) for (_, name), kind in kinds.items()]


def check_importable(scenario: Scenario) -> None:
    """Raise FesError in one line if an extension is a class of the program itself, such as a notebook."""
    for _, kind, choice in scenario.choices:
        name = chosen(choice).use
        if name.startswith(f"{evidence.PROGRAM}:"):
            raise FesError(f"{kind.name} '{name}': no other process can import it; put the class into a file")


def check(scenario: Scenario, recorded: list[Any], where: str) -> None:
    """Raise FesError in one line unless the extensions of a scenario are those `recorded` at `where`."""
    before = {(entry["kind"], entry["name"]): entry for entry in recorded}
    for now in of(scenario):
        known = before.get((now.kind, now.name))
        difference = evidence.difference(known, now) if known else f"{now.kind} '{now.name}' was not recorded"
        if difference:
            raise FesError(f"{where}: {difference}")


def check_recorded(recorded: Any, where: str) -> None:
    """Load the extensions `recorded` at `where`, as far as this process may; raises FesError if one has changed.

    After it, a state that holds objects of their classes can be read.
    """
    try:
        entries = [(_KIND[entry["kind"]], str(entry["name"]), dict(entry)) for entry in recorded]
    except (KeyError, TypeError, ValueError) as error:
        raise FesError(f"{where} is damaged: its extensions cannot be read: {type(error).__name__}") from None
    for kind, name, entry in entries:
        difference = evidence.difference(entry, evidence.of(kind, name, registry.load(kind, name)))
        if difference:
            raise FesError(f"{where}: {difference}")
