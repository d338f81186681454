"""Conflicts of our package names with those of other projects."""

import base64
import hashlib
from collections.abc import Iterator
from importlib import metadata
from importlib.metadata import Distribution
from pathlib import Path

from console.doctor.finding import Finding, failed, ok, warning
from fes.system import distribution

CHECK = "our names"


def own() -> Iterator[Finding]:
    """Failed if Python finds another project's package under one of our names; a warning if both are installed."""
    wrong = [*distribution.foreign(), *overwritten()]
    if wrong:
        yield failed(CHECK, "; ".join(wrong), distribution.separate())
        return
    shared = [
        f"{', '.join(others)} has the package '{package}' too" for package, others in _sharers().items() if others
    ]
    if shared:
        remedy = f"only one of them works, and removing one breaks the other: {distribution.separate()}"
        yield warning(CHECK, "; ".join(shared), remedy)
        return
    try:
        stranger = metadata.version(distribution.STRANGER)
    except metadata.PackageNotFoundError:
        yield ok(CHECK, f"{', '.join(distribution.PACKAGES)} are those in {distribution.HOME}")
        return
    seen = f"'{distribution.STRANGER}' {stranger} is installed; this project is '{distribution.NAME}'"
    yield warning(CHECK, seen, f"pip uninstall {distribution.STRANGER}, then {distribution.install()}")


def overwritten(files: Distribution | None = None) -> Iterator[str]:
    """Each of our packages whose first file was overwritten or removed, and the likely owner of the new file.

    An editable installation has no list of files to compare with.
    """
    try:
        installed = files or metadata.distribution(distribution.NAME)
    except metadata.PackageNotFoundError:
        return
    first = {f"{package}/__init__.py" for package in distribution.PACKAGES}
    for file in installed.files or []:
        if file.as_posix() not in first or file.hash is None or file.hash.mode not in hashlib.algorithms_guaranteed:
            continue
        try:
            content = Path(str(file.locate())).read_bytes()
        except OSError:
            yield f"{file} is missing, and {distribution.NAME} {installed.version} installed it"
            continue
        digest = base64.urlsafe_b64encode(hashlib.new(file.hash.mode, content).digest()).rstrip(b"=").decode()
        if digest != file.hash.value:
            others = ", ".join(_sharers().get(file.parts[0], [])) or "another project"
            yield f"{file} is not what {distribution.NAME} {installed.version} installed: {others} wrote over it"


def _sharers() -> dict[str, list[str]]:
    """Other distributions with a package of the same name, for each of our packages."""
    owners = metadata.packages_distributions()
    return {package: sorted(set(owners.get(package, [])) - {distribution.NAME}) for package in distribution.PACKAGES}
