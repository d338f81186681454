"""Rules for a finished file of a release: what it is called, what it holds, and which systems can load that."""

import tarfile
import zipfile
from collections.abc import Iterator
from pathlib import Path, PurePosixPath

import build_core
from deploy.wheels.libraries import needs
from deploy.wheels.platforms import ANY, GLIBC, MACOS, PLATFORMS, SOURCE

LIBRARIES = {f"{name}{build_core.SUFFIX}" for name in build_core.LIBRARIES}


def problems(path: Path, name: str) -> list[str]:
    """Every rule that the file of a platform breaks, in one line each."""
    if name == SOURCE:
        return list(_of_source(path))
    if name == ANY:
        return list(_of_any(path))
    return list(_of_platform(path, name))


def _of_source(path: Path) -> Iterator[str]:
    with tarfile.open(path) as archive:
        # The first folder has the name of the distribution.
        held = {str(PurePosixPath(*PurePosixPath(member).parts[1:])) for member in archive.getnames()}
    wanted = {file.relative_to(build_core.ROOT) for files in build_core.libraries().values() for file in files}
    headers = {header for file in wanted for header in (build_core.ROOT / file).parent.glob("*.h")}
    wanted |= {header.relative_to(build_core.ROOT) for header in headers}
    for file in sorted({*map(str, wanted), "build_core.py", "hatch_build.py"} - held):
        yield f"{file} is missing"
    yield from (f"{file} is compiled" for file in sorted(held) if file.endswith(build_core.SUFFIX))
    yield from (f"{file} is a key" for file in sorted(held) if file.endswith(".key"))


def _of_any(path: Path) -> Iterator[str]:
    if not path.name.endswith("-py3-none-any.whl"):
        yield "its name is not that of a wheel for every platform"
    yield from (f"{name} is compiled" for name in _libraries(path))


def _of_platform(path: Path, name: str) -> Iterator[str]:
    if not path.name.endswith(f"-py3-none-{'.'.join(PLATFORMS[name].tags)}.whl"):
        yield "its name does not have the platform's tags"
    content = _libraries(path)
    if set(content) != LIBRARIES:
        yield f"its libraries are {', '.join(sorted(content)) or 'none'}"
    for library, data in content.items():
        yield from (f"{library}: {problem}" for problem in _of_library(data, name))


def _of_library(data: bytes, name: str) -> Iterator[str]:
    try:
        own = needs(data)
    except ValueError as error:
        yield str(error)
        return
    if f"{own.system}-{own.machine}" != name:
        yield f"it is for {own.system}-{own.machine}"
    if own.version > (oldest := GLIBC if own.system == "linux" else MACOS):
        yield f"it needs version {own.version} of the system, and the oldest is {oldest}"
    if own.machine == "arm64" and not own.is_signed:
        yield "it has no signature, which macOS demands"
    if "/" in own.name:
        yield f"it names a folder of the machine that built it: {own.name}"


def _libraries(wheel: Path) -> dict[str, bytes]:
    """Content of each library of a wheel."""
    with zipfile.ZipFile(wheel) as archive:
        return {name: archive.read(name) for name in archive.namelist() if name.endswith(build_core.SUFFIX)}
