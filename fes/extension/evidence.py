"""Evidence: the code of an extension, so that a run is repeated only with the same code."""

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
    """Label -> file of each module: of the distribution, of the package, or of the one file."""
    path = getattr(module, "__file__", None)
    file = None if path is None else Path(path).resolve()
    if distribution is not None:
        listed = [file for file in distribution.files or () if file.suffix == ".py"]
        sources = {str(file): Path(str(distribution.locate_file(file))) for file in listed}
        if file is not None and file in {path.resolve() for path in sources.values() if path.is_file()}:
            return sources  # an editable installation lists no module of its own
    if file is None:
        return {}  # a notebook has no file
    package = sys.modules[module.__name__.partition(".")[0]]
    if not hasattr(package, "__path__"):
        return {file.name: file}
    root = Path(next(iter(package.__path__)))
    return {str(path.relative_to(root.parent)): path for path in root.rglob("*.py")}
