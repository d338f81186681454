"""Extensions by name: built-in ones by dotted path, installed ones by entry point, others as `module:Class`.

A name is resolved only where it is used, so no process loads a law that it does not run. A `module:Class` is loaded
only from a module that this process was told to use (`--use`): a message or a file never makes it import code.
"""

import difflib
import importlib
import sys
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import ValidationError

from fes.errors import FesError
from fes.extension.context import LawContext
from fes.extension.controllers import ControllerFormation, ControllerSeeking
from fes.extension.protocols import MAX_DECLARED, FormationLaw, NeighborRule, SeekingLaw
from fes.model.config import AgentConfig
from fes.model.seeking import MeasuredConfig, SeekingConfig
from fes.model.table import Table, Use, chosen


class Kind(NamedTuple):
    """A kind of extension."""

    name: str
    """In words, such as `neighbor rule`."""
    group: str
    """Group of entry points."""
    built_in: dict[str, str]
    """Name -> `module:Class` of those that come with fes."""


RULE = Kind(
    "neighbor rule",
    "fes.neighbor_rules",
    {
        "disk": "agents.laws.neighbor_rules:Disk",
        "two_nearest": "agents.laws.neighbor_rules:TwoNearest",
        "relative_neighborhood": "agents.laws.neighbor_rules:RelativeNeighborhood",
    },
)
FORMATION = Kind("formation law", "fes.formation_laws", {"paper": "agents.laws.formation:PaperFormation"})
SEEKING = Kind(
    "seeking law",
    "fes.seeking_laws",
    {
        "oracle": "agents.laws.oracle:OracleSeeking",
        "sampled": "agents.laws.seeking_perturbation:SampledSeeking",
        "measured, network": "agents.laws.seeking_measured:PooledSeeking",
        "measured, none": "agents.laws.seeking_measured:LinkSeeking",
    },
)
CONTROLLER = Kind("controller", "fes.controllers", {})
CHANNEL = Kind("channel", "fes.channels", {})
DYNAMICS = Kind("dynamics", "fes.dynamics", {})
METRIC = Kind("metric", "fes.metrics", {})

KINDS = (CONTROLLER, FORMATION, SEEKING, RULE, CHANNEL, DYNAMICS, METRIC)

_usable: dict[str, Any] = {}
"""Modules that this process was told to use, by name."""


class Laws(NamedTuple):
    """The laws of a crew."""

    rule: NeighborRule
    formation: FormationLaw[Any]
    seeking: SeekingLaw[Any]


def use(module: str) -> str:
    """Import a module by name, or by the path of its file, and allow its classes; returns its name.

    It is looked for in the current directory too. Raises FesError in one line.
    """
    path = Path(module)
    name, folder = (path.stem, str(path.parent.resolve())) if path.suffix == ".py" else (module, str(Path.cwd()))
    if folder not in sys.path:
        sys.path.append(folder)
    try:
        _usable[name] = importlib.import_module(name)
    except Exception as error:  # the module is anybody's code
        raise FesError(f"--use {module}: {type(error).__name__}: {' '.join(str(error).split())}") from None
    return name


def load(kind: Kind, name: str) -> Any:
    """The class of an extension; raises FesError in one line."""
    path = kind.built_in.get(name)
    if path is not None:
        return _attribute(path, f"{kind.name} '{name}'")
    module, colon, _ = name.partition(":")
    if colon:
        if module not in _usable:
            raise FesError(
                f"{kind.name} '{name}': this process was not told to use module '{module}' (--use {module})"
            )
        return _attribute(name, f"{kind.name} '{name}'")
    found = _entry_points(kind.group)
    if name in found:
        try:
            return found[name].load()
        except Exception as error:  # the module is anybody's code
            raise FesError(f"{kind.name} '{name}': {type(error).__name__}: {' '.join(str(error).split())}") from None
    known = [*kind.built_in, *found]
    near = difflib.get_close_matches(name, known, 1)
    hint = f"did you mean '{near[0]}'?" if near else f"known are {', '.join(known) or 'none'}, and `module:Class`"
    raise FesError(f"there is no {kind.name} '{name:.60}'; {hint}")


def parameters(kind: Kind, choice: str | Use, loaded: Any) -> Table:
    """The parameters of a choice, checked by its class; raises FesError in one line that names the extension."""
    selected = chosen(choice)
    table = getattr(loaded, "Parameters", None)
    if not (isinstance(table, type) and issubclass(table, Table)):
        raise FesError(f"{kind.name} '{selected.use}': its `Parameters` is not a subclass of `fes.extension.Table`")
    try:
        return table.model_validate(selected.parameters)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        field = ".".join(map(str, first["loc"]))
        if first["type"] == "extra_forbidden":
            near = difflib.get_close_matches(field, table.model_fields, 1)
            known = f"did you mean '{near[0]}'?" if near else f"it has {', '.join(table.model_fields) or 'none'}"
            raise FesError(f"{kind.name} '{selected.use}': unknown parameter '{field}'; {known}") from None
        message = first["msg"].removeprefix("Value error, ").replace("Input should be", "must be")
        raise FesError(f"{kind.name} '{selected.use}': {field}: {message}".replace(": : ", ": ")) from None


def create(kind: Kind, choice: str | Use, context: Any) -> Any:
    """An extension; raises FesError in one line."""
    loaded = load(kind, chosen(choice).use)
    checked = parameters(kind, choice, loaded)
    try:
        return loaded(checked, context)
    except FesError:
        raise
    except Exception as error:  # the class is anybody's code
        text = " ".join(str(error).split())
        raise FesError(f"{kind.name} '{chosen(choice).use}': {type(error).__name__}: {text}") from None


def knows_channel(config: SeekingConfig) -> bool:
    """True if the law must be told the channel; no built-in law is loaded. Raises FesError in one line."""
    return bool(load(SEEKING, config.use).knows_channel) if isinstance(config, Use) else config.knows_channel


def physical_period(config: SeekingConfig) -> float | None:
    """Period of the oscillation that the law imposes on the formation [s]; None without one.

    An extension may have a static method `physical_period(parameters)`. Raises FesError in one line.
    """
    if not isinstance(config, Use):
        return config.physical_period
    loaded = load(SEEKING, config.use)
    if not hasattr(loaded, "physical_period"):
        return None
    period: float | None = loaded.physical_period(parameters(SEEKING, config, loaded))
    return period


def laws(config: AgentConfig, context: LawContext) -> Laws:
    """The laws of a crew with `config`; raises FesError in one line."""
    rule = create(RULE, config.formation.rule, context)
    if config.controller is not None:
        controller = load(CONTROLLER, chosen(config.controller).use)
        checked = parameters(CONTROLLER, config.controller, controller)
        return Laws(rule, ControllerFormation(controller, checked, context), ControllerSeeking(controller, context))
    formation = create(FORMATION, config.formation.law, context)
    if isinstance(config.seeking, Use):
        seeking = create(SEEKING, config.seeking, context)
    else:
        seeking = load(SEEKING, _seeking_name(config.seeking))(config.seeking, context)
    declared = formation.declared + seeking.declared
    if declared > MAX_DECLARED:
        raise FesError(f"the laws declare {declared} bytes in each beacon: at most {MAX_DECLARED} are allowed")
    return Laws(rule, formation, seeking)


def _seeking_name(config: SeekingConfig) -> str:
    if isinstance(config, Use):
        return config.use
    return f"measured, {config.pooling}" if isinstance(config, MeasuredConfig) else config.index


def _attribute(path: str, what: str) -> Any:
    """The class at `module:Class`; raises FesError in one line."""
    module, _, attribute = path.partition(":")
    loaded: Any = importlib.import_module(module)
    try:
        for part in attribute.split("."):
            loaded = getattr(loaded, part)
    except AttributeError:
        classes = [name for name, value in vars(loaded).items() if isinstance(value, type)]
        near = difflib.get_close_matches(attribute, classes, 1)
        hint = f"; did you mean '{near[0]}'?" if near else ""
        raise FesError(f"{what}: module '{module}' has no class '{attribute}'{hint}") from None
    return loaded


@cache
def _entry_points(group: str) -> dict[str, metadata.EntryPoint]:
    return {entry.name: entry for entry in metadata.entry_points(group=group)}
