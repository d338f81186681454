"""Extensions by name: built-in ones by dotted path, installed ones by entry point, others as `module:Class`.

A name is resolved only where it is used, so no process loads a law that it does not run. A `module:Class` is loaded
only from a module that this process was started with (`--use`). A message or a file never makes it import code.
"""

import difflib
import importlib
import sys
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from fes.errors import FesError
from fes.extension import evidence
from fes.extension.checked import Checked
from fes.extension.kinds import Kind
from fes.model.table import Table, Use, chosen

_arguments: dict[str, str] = {}
"""Module that this process was told to use -> the argument that names it for another process."""

_loaded: set[str] = set()
"""Modules that hold the classes of the extensions that this process has loaded."""


def use(module: str) -> str:
    """Import a module by name, or by the path of its file, and allow its classes; returns its name.

    A name is searched in the current directory too. If its source has changed since it was used, it is imported
    again. Raises FesError in one line; nothing has changed then.
    """
    path = Path(module).resolve()
    name, folder = (path.stem, str(path.parent)) if path.suffix == ".py" else (module, str(Path.cwd()))
    is_new = folder not in sys.path
    if is_new:
        sys.path.append(folder)
    try:
        evidence.import_module(name, path if path.suffix == ".py" else None)
    except Exception as error:  # the module is anybody's code
        if is_new:
            sys.path.remove(folder)
        raise FesError(f"--use {module}: {type(error).__name__}: {' '.join(str(error).split())}") from None
    _arguments[name] = str(path) if path.suffix == ".py" else module
    return name


def withdraw(name: str) -> None:
    """Allow the classes of a module no longer; `name` is what `use` returned."""
    _arguments.pop(name, None)


def used() -> tuple[str, ...]:
    """The modules that this process was told to use, as a child process is told to: all but the program itself."""
    return tuple(argument for name, argument in _arguments.items() if name != evidence.PROGRAM)


def is_path(module: str) -> bool:
    """True if the text before the colon of a name is the path of a file, not the name of a module."""
    return module.endswith(".py") or "/" in module


def is_usable(module: str) -> bool:
    """True if objects of a module of others may be read: this process uses it, or has loaded an extension from it.

    The other modules of a package are not, even if they are imported already. Those of the project never are.
    """
    return evidence.top_level(module) not in evidence.OWN and (module in _arguments or module in _loaded)


def load(kind: Kind, name: str) -> Any:
    """The class of an extension; raises FesError in one line."""
    path = kind.built_in.get(name)
    if path is not None:
        return _attribute(path, f"{kind.name} '{name}'")
    module, colon, _ = name.partition(":")
    if colon and is_path(module):
        written = f"{Path(module).stem}:{name.rpartition(':')[2]}"
        raise FesError(
            f"{kind.name} '{name}': a class is named by its module, not by a path: write '{written}' "
            f"(--use {Path(module).with_suffix('.py')})"
        )
    installed = _entry_points(kind.group)
    if colon and module not in _arguments:
        raise FesError(f"{kind.name} '{name}': this process was not told to use module '{module}' (--use {module})")
    if not colon and name not in installed:
        known = [*kind.built_in, *installed]
        near = difflib.get_close_matches(name, known, 1)
        hint = f"did you mean '{near[0]}'?" if near else f"known are {', '.join(known) or 'none'}, and `module:Class`"
        raise FesError(f"there is no {kind.name} '{name:.60}'; {hint}")
    try:
        loaded = _attribute(name, f"{kind.name} '{name}'") if colon else installed[name].load()
    except FesError:
        raise
    except Exception as error:  # the module is anybody's code
        raise FesError(f"{kind.name} '{name}': {type(error).__name__}: {' '.join(str(error).split())}") from None
    module = module if colon else installed[name].module
    home = getattr(loaded, "__module__", module)
    if evidence.top_level(home) == evidence.top_level(module):
        _loaded.add(home)
    if home in sys.modules:
        evidence.note(home)
    return loaded


def installed(kind: Kind) -> tuple[str, ...]:
    """The names of the extensions of a kind that other distributions provide."""
    return tuple(_entry_points(kind.group))


def parameters(kind: Kind, choice: str | Use, loaded: Any) -> Table:
    """The parameters of a choice, checked by its class; raises FesError in one line that names the extension."""
    selected = chosen(choice)
    if selected.use not in kind.built_in and (member := kind.missing(loaded)):
        raise FesError(f"{kind.name} '{selected.use}': it has no method `{member}`")
    table = getattr(loaded, "Parameters", None)
    if not (isinstance(table, type) and issubclass(table, Table)):
        raise FesError(f"{kind.name} '{selected.use}': its `Parameters` is not a subclass of `fes.extension.Table`")
    try:
        return table.model_validate(selected.parameters)
    except ValidationError as error:
        # an unknown parameter is reported first: it may be a required one, misspelt
        first = min(error.errors(include_url=False), key=lambda broken: broken["type"] != "extra_forbidden")
        field = ".".join(map(str, first["loc"]))
        if first["type"] == "extra_forbidden":
            near = difflib.get_close_matches(field, table.model_fields, 1)
            known = f"did you mean '{near[0]}'?" if near else f"it has {', '.join(table.model_fields) or 'none'}"
            raise FesError(f"{kind.name} '{selected.use}': unknown parameter '{field}'; {known}") from None
        message = first["msg"].removeprefix("Value error, ").replace("Input should be", "must be")
        message = message.replace("Field required", "is required")
        raise FesError(f"{kind.name} '{selected.use}': {field}: {message}".replace(": : ", ": ")) from None


def check(kind: Kind, choice: str | Use) -> None:
    """Raise FesError in one line unless an extension exists and accepts its parameters.

    A built-in one without parameters is not loaded.
    """
    selected = chosen(choice)
    if selected.use not in kind.built_in or selected.parameters:
        parameters(kind, choice, load(kind, selected.use))


def is_told(kind: Kind, choice: str | Use) -> bool:
    """True if a law or a controller must be told the channel; loads no built-in one. Raises FesError in one line."""
    name = chosen(choice).use
    if name in kind.built_in:
        return name in kind.model_based
    return bool(getattr(load(kind, name), "knows_channel", False))


def create(kind: Kind, choice: str | Use, context: Any, given: Table | None = None) -> Any:
    """An object of an extension, checked at each call unless it is built in. Raises FesError in one line.

    `given` are the parameters of a built-in one, if they are not in `choice`.
    """
    name = chosen(choice).use
    loaded = load(kind, name)
    if name in kind.built_in and given is not None:
        return loaded(given, context)
    checked = parameters(kind, choice, loaded)
    if name in kind.built_in:
        return loaded(checked, context)
    what = f"{kind.name} '{name}'"
    extension = Checked(loaded, what).call(loaded, checked, context)
    return kind.checked(extension, what, context)


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
