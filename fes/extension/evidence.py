"""Evidence: the code of an extension, so that a run is repeated only with the same code.

The source of a module is hashed when this process imports it. So the evidence is that of the code in memory, also
after the file has changed.
"""

import contextlib
import hashlib
import importlib
import sys
from collections.abc import Mapping
from functools import lru_cache
from importlib import metadata
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

from fes.extension.kinds import Kind

OWN = frozenset({"fes", "agents", "world", "field", "console"})
"""Packages of the project."""

PROGRAM = "__main__"
"""Module of a script or a notebook, which no other process can import."""

_RUNNING = OWN | {PROGRAM}
"""Packages that are never imported again."""


class Code(NamedTuple):
    """The source of a module, with all that belongs to it: of its distribution, of its package, or its one file."""

    module: str
    distribution: str
    """Its distribution, or the names of its files if it has none."""
    version: str
    """Version of the distribution; empty without one."""
    sha256: str
    files: frozenset[Path]


_codes: dict[str, Code] = {}
"""Top-level package -> its source when this process imported it."""


class Evidence(NamedTuple):
    """The code of one extension."""

    kind: str
    name: str
    """As the scenario names it."""
    path: str
    """`module:Class`."""
    distribution: str
    """Its distribution, or the name of its file if it has none."""
    version: str
    """Version of the distribution; empty without one."""
    sha256: str
    """SHA-256 over all its modules."""

    @property
    def table(self) -> dict[str, str]:
        """As written to a log or a checkpoint."""
        return self._asdict()


def import_module(name: str, file: Path | None) -> None:
    """Import a module, which must be this `file` if there is one, and note its source.

    If the source has changed since this process noted it, all its modules are imported again. After an error, the
    former ones are in place.
    """
    importlib.invalidate_caches()  # a file may be younger than the last look into its folder
    changed = _changed(top_level(name))
    former = _unload(changed)
    try:
        module = importlib.import_module(name)
        if file is not None and Path(getattr(module, "__file__", None) or "").resolve() != file:
            raise ImportError(f"another module is named '{name}': rename the file")
    except BaseException:
        sys.modules.update(former)
        raise
    for code in changed:
        del _codes[top_level(code.module)]
    note(name)


def note(name: str) -> None:
    """Note the source of an imported module, unless that of its package is noted."""
    if top_level(name) not in _codes:
        _codes[top_level(name)] = on_disk(name)


def on_disk(name: str) -> Code:
    """The source of an imported module, as it is on the disk now."""
    distribution = _distribution(top_level(name))
    sources = _sources(distribution, sys.modules[name])
    digest = hashlib.sha256()
    for label, source in sorted(sources.items()):
        digest.update(f"{label}\0{source.stat().st_size}\0".encode() + source.read_bytes())
    title = distribution.name if distribution is not None else ", ".join(sorted(sources))
    version = distribution.version if distribution is not None else ""
    files = frozenset(source.resolve() for source in sources.values())
    return Code(name, title, version, digest.hexdigest(), files)


def of(kind: Kind, name: str, loaded: Any) -> Evidence:
    """The evidence of an extension whose class `loaded` is not built in."""
    path = f"{loaded.__module__}:{loaded.__qualname__}"
    code = _codes[top_level(loaded.__module__)]
    return Evidence(kind.name, name, path, code.distribution, code.version, code.sha256)


def top_level(name: str) -> str:
    """The top-level package of a module, or the module itself."""
    return name.partition(".")[0]


def difference(recorded: dict[str, Any], now: Evidence) -> str:
    """The difference of an extension from the one that was `recorded`, in words; empty without one."""
    what = f"{now.kind} '{now.name}'"
    for field in ("path", "distribution", "version"):
        if recorded.get(field) != getattr(now, field):
            return (
                f"{what} is of {field} '{getattr(now, field)}', and the run was recorded with '{recorded.get(field)}'"
            )
    before, after = str(recorded.get("sha256"))[:12], now.sha256[:12]
    return (
        "" if before == after else f"the source of {what} has changed: SHA-256 {before}... recorded, now {after}..."
    )


def _changed(top: str) -> list[Code]:
    """The noted sources that have files in common with a package that has changed; none if it has not."""
    noted = _codes.get(top)
    if noted is None or top in _RUNNING or (noted.module in sys.modules and on_disk(noted.module) == noted):
        return []
    return [code for code in _codes.values() if code is noted or code.files & noted.files]


def _unload(codes: list[Code]) -> dict[str, ModuleType]:
    """Remove the modules of these sources from this process; returns them by name."""
    files = {file for code in codes for file in code.files}
    imported = [(name, getattr(module, "__file__", None), module) for name, module in sys.modules.items() if files]
    former = {
        name: module
        for name, file, module in imported
        if file is not None and top_level(name) not in _RUNNING and Path(file).resolve() in files
    }
    for name, module in former.items():
        del sys.modules[name]
        # a cached file is valid by time [s] and size alone, so a quick change could go unseen
        with contextlib.suppress(OSError):
            Path(getattr(module, "__cached__", None) or "").unlink()
    return former


def _distribution(top: str) -> metadata.Distribution | None:
    names = _distributions(tuple(sys.path)).get(top)
    return metadata.distribution(names[0]) if names else None


@lru_cache(maxsize=1)
def _distributions(path: tuple[str, ...]) -> Mapping[str, list[str]]:
    """Top-level package -> names of its distributions, as found on this path [0.1 s]."""
    return metadata.packages_distributions()


def _sources(distribution: metadata.Distribution | None, module: Any) -> dict[str, Path]:
    """Label -> file of each module of the distribution, or else of the package; the module's own is always there."""
    listed = (distribution.files if distribution is not None else None) or []
    sources = _modules({str(file): Path(str(file.locate())) for file in listed})
    path = getattr(module, "__file__", None)  # a notebook has no file
    own = None if path is None else Path(path).resolve()
    if own in {source.resolve() for source in sources.values()}:
        return sources
    # an editable installation lists no module of its own
    package = sys.modules[top_level(module.__name__)]
    roots = [Path(root) for root in getattr(package, "__path__", ())]
    sources = _modules({str(file.relative_to(root.parent)): file for root in roots for file in root.rglob("*.py")})
    if own is not None and own not in {source.resolve() for source in sources.values()}:
        sources[own.name] = own
    return sources


def _modules(files: dict[str, Path]) -> dict[str, Path]:
    return {label: file for label, file in files.items() if file.suffix == ".py" and file.is_file()}
