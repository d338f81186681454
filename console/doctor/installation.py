"""Our packages, whose names other projects use too: what Python finds under them, and what wrote over them."""

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
    """Failed where one of our packages is another project's; a warning where another project has one of that name."""
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
    """Each of our packages whose first file is not the one that was installed, and the likely owner of that file.

    An installation of a clone keeps no list of files: there is nothing to compare.
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
    """Package of ours -> other distributions with a package of that name."""
    owners = metadata.packages_distributions()
    return {package: sorted(set(owners.get(package, [])) - {distribution.NAME}) for package in distribution.PACKAGES}
