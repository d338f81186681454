"""The extension to check: its kind, its class, and short runs that use it."""

from typing import Any, NamedTuple

from pydantic import ValidationError

from fes.errors import FesError
from fes.extension import registry
from fes.extension.kinds import (
    CHANNEL,
    CONTROLLER,
    DYNAMICS,
    FORMATION,
    KINDS,
    METRIC,
    RULE,
    SEEKING,
    Kind,
    infer,
    nearest,
)
from fes.model.table import Use
from fes.settings.validation import first_rule
from world.config import scenario
from world.config.scenario import Scenario

ROBOTS = 5
"""Number of robots of a run: several crews of several robots each."""

RESTARTED = 1
"""The robot that leaves during a run, and rejoins without state."""

ANY = Kind("extension", "", {})
"""Stands for a kind that is not known yet."""

LAWS = (CONTROLLER, FORMATION, SEEKING, RULE)
"""Kinds that robots execute; the world executes the others."""


class Subject(NamedTuple):
    """An extension to check."""

    kind: Kind
    name: str
    """As a scenario names it."""
    loaded: Any
    """Its class."""
    parameters: dict[str, Any]

    @property
    def title(self) -> str:
        """Its kind and name, as in errors."""
        return f"{self.kind.name} '{self.name}'"

    @property
    def is_law(self) -> bool:
        """True if robots execute it."""
        return self.kind in LAWS

    def tables(self, seed: int) -> dict[str, Any]:
        """The tables of a short run: all robots in range, one of which leaves and rejoins."""
        choice = {"use": self.name, **self.parameters}
        robots: dict[str, Any] = {"count": ROBOTS, "jitter": 8.0}
        formation: dict[str, Any] = {"rule": "disk"}
        tables: dict[str, Any] = {
            "schema": 1,
            "run": {"duration": 3.0, "seed": seed},
            "robots": robots,
            "seeking": {"index": "measured"},
            "formation": formation,
            "event": [{"at": 1.0, "kill": [RESTARTED]}, {"at": 1.6, "restart": [RESTARTED]}],
        }
        if self.kind is CONTROLLER:
            robots["controller"] = choice
        elif self.kind is DYNAMICS:
            robots["dynamics"] = choice
        elif self.kind is FORMATION:
            formation["law"] = choice
        elif self.kind is RULE:
            formation["rule"] = choice
        elif self.kind is SEEKING:
            tables["seeking"] = choice
        elif self.kind is CHANNEL:
            tables["channel"] = {"model": choice}
        elif self.kind is METRIC:
            tables["metric"] = [choice]
        return tables

    def scenario(self, seed: int = 7) -> Scenario:
        """The short run with a seed; raises FesError if the extension is not one of its kind."""
        try:
            choice = Use.model_validate({"use": self.name, **self.parameters})
        except ValidationError as error:
            raise FesError(f"{self.title}: {first_rule(error, Use, 'its parameters')}") from None
        registry.check(self.kind, choice)
        return scenario.parse(self.tables(seed), "check")


def of(extension: str | type, kind: str | None = None, parameters: dict[str, Any] | None = None) -> Subject:
    """The subject that a class is, or a name: `module:Class`, or that of an installed extension.

    Raises FesError in one line if it is not there, or if its kind is not clear and not given.
    """
    name = extension if isinstance(extension, str) else _name(extension)
    kinds = KINDS if kind is None else tuple(known for known in KINDS if slug(known) == kind)
    if not kinds:
        raise FesError(f"there is no kind '{kind}' of extension; known are {', '.join(map(slug, KINDS))}")
    module, colon, _ = name.partition(":")
    if colon:
        if not registry.is_path(module):
            registry.use(module)
        loaded = registry.load(kinds[0] if kind else ANY, name)
        kinds = kinds if kind else tuple(infer(loaded))
    else:
        kinds = tuple(known for known in kinds if name in registry.installed(known))
        if not kinds:
            raise FesError(
                f"extension '{name}': none is installed under this name; a file is named by `module:Class`"
            )
        loaded = registry.load(kinds[0], name)
    if len(kinds) != 1:
        raise FesError(f"extension '{name}': {_unclear(loaded, kinds)}")
    return Subject(kinds[0], name, loaded, parameters or {})


def _unclear(loaded: Any, kinds: tuple[Kind, ...]) -> str:
    """The reason why the kind of a class is not clear."""
    near = nearest(loaded)
    if kinds:
        return f"it has the methods of {' and of '.join(known.name for known in kinds)}; choose with --kind"
    if near is None:
        return "it has no method of any kind of extension"
    return f"nearest is {near.name}, but it has no method `{near.missing(loaded)}`"


def slug(kind: Kind) -> str:
    """The kind as the argument of a flag.

    >>> slug(FORMATION)
    'formation-law'
    """
    return kind.name.replace(" ", "-")


def _name(loaded: type) -> str:
    """The name of a class, by which a child process can import it too; raises FesError."""
    if "<locals>" in loaded.__qualname__ or loaded.__module__ == "__main__":
        raise FesError(f"extension '{loaded.__qualname__}': it must be in a module, not in a function or a script")
    return f"{loaded.__module__}:{loaded.__qualname__}"


SLUGS = tuple(map(slug, KINDS))
"""The seven kinds, as arguments of a flag."""
