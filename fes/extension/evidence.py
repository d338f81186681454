"""Evidence: which code an extension was, so that a run is repeated only with the same."""

import hashlib
import sys
from importlib import metadata
from pathlib import Path
from typing import Any, NamedTuple

from fes.extension import registry
from fes.extension.kinds import Kind


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


def of(kind: Kind, name: str) -> Evidence:
    """The evidence of an extension that is not built in; raises FesError in one line."""
    loaded: Any = registry.load(kind, name)
    module = sys.modules[loaded.__module__]
    path = f"{loaded.__module__}:{loaded.__qualname__}"
    distribution = _distribution(loaded.__module__.partition(".")[0])
    sources = _sources(distribution, module)
    digest = hashlib.sha256()
    for label, source in sorted(sources.items()):
        digest.update(f"{label}\0{source.stat().st_size}\0".encode() + source.read_bytes())
    title = distribution.name if distribution is not None else ", ".join(sorted(sources))
    return Evidence(kind.name, name, path, title, distribution.version if distribution else "", digest.hexdigest())


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


def _distribution(top: str) -> metadata.Distribution | None:
    names = metadata.packages_distributions().get(top)
    return metadata.distribution(names[0]) if names else None


def _sources(distribution: metadata.Distribution | None, module: Any) -> dict[str, Path]:
    """Label -> file of each module of the distribution, or else of the package; the module's own is always there."""
    listed = (distribution.files if distribution is not None else None) or []
    sources = _modules({str(file): Path(str(file.locate())) for file in listed})
    path = getattr(module, "__file__", None)  # a notebook has no file
    own = None if path is None else Path(path).resolve()
    if own in {source.resolve() for source in sources.values()}:
        return sources
    # an editable installation lists no module of its own
    package = sys.modules[module.__name__.partition(".")[0]]
    roots = [Path(root) for root in getattr(package, "__path__", ())]
    sources = _modules({str(file.relative_to(root.parent)): file for root in roots for file in root.rglob("*.py")})
    if own is not None and own not in {source.resolve() for source in sources.values()}:
        sources[own.name] = own
    return sources


def _modules(files: dict[str, Path]) -> dict[str, Path]:
    return {label: file for label, file in files.items() if file.suffix == ".py" and file.is_file()}
