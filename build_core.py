"""Builds the compiled core: four small libraries in C that repeat the numpy code to the bit.

`pip install` calls it through hatch_build.py. From a clone, `python build_core.py` builds the libraries in place.
It imports nothing but the standard library: it runs before the dependencies are installed.

CC            a compiler, with further flags; by default cc, gcc or clang
FES_PLATFORM  the platform of the wheel, if that compiler builds for another one
FES_CORE      `c`: no wheel without the core; `numpy`: no core; by default a core if a compiler is found
"""

import os
import platform
import shlex
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).parent

LIBRARIES = {
    "fes/arithmetic/core/libelementary": ["fes/arithmetic/core"],
    "agents/core/librobots": ["agents/core"],
    "agents/laws/core/libformula_index": ["agents/laws/core"],
    "world/simulation/core/libworld": ["world/simulation/core"],
}
"""Library, without its suffix -> the folders of its C files."""

SUFFIX = ".so"
"""Of a library, on every system: only ctypes loads it."""

FLAGS = (
    "-std=gnu11",
    "-O2",
    "-ftree-vectorize",
    "-ffp-contract=off",  # with no fast mathematics, this is the whole contract with the compiler
    "-fno-math-errno",
    "-fno-trapping-math",
    "-fPIC",
    "-fvisibility=hidden",
    "-shared",
    "-Wall",
    "-Wextra",
)


class NotBuilt(Exception):
    """No core was built; the text gives the reason."""


def wanted() -> str:
    """The core that FES_CORE asks for: `c`, `numpy`, or an empty text."""
    return os.environ.get("FES_CORE", "")


def compiler() -> list[str]:
    """The C compiler and its flags: $CC, or the first of cc, gcc and clang on the path. Raises NotBuilt."""
    if named := shlex.split(os.environ.get("CC", "")):
        return named
    if found := next((name for name in ("cc", "gcc", "clang") if shutil.which(name)), None):
        return [found]
    raise NotBuilt("there is no C compiler")


def libraries(root: Path = ROOT) -> dict[Path, list[Path]]:
    """Each library of a tree, and its C files."""
    return {
        root / f"{name}{SUFFIX}": sorted(file for folder in folders for file in (root / folder).glob("*.c"))
        for name, folders in LIBRARIES.items()
    }


def build(root: Path = ROOT, into: Path | None = None) -> list[Path]:
    """Compile all libraries of a tree; returns their files, in their packages or under the folder `into`.

    Raises NotBuilt.
    """
    if not is_supported():
        raise NotBuilt("it is meant for Linux and macOS, on machines of 64 bits with the lowest byte first")
    command = [*compiler(), *FLAGS, f"-I{root}"]
    built = []
    for library, sources in libraries(root).items():
        target = library if into is None else into / library.relative_to(root)
        target.parent.mkdir(parents=True, exist_ok=True)
        # In a folder of its own: a process that has the old library open keeps it, and the new one names no path.
        with tempfile.TemporaryDirectory(prefix=".core-", dir=target.parent) as folder:
            _run([*command, "-o", target.name, *map(str, sources)], folder)
            (Path(folder) / target.name).replace(target)
        built.append(target)
    return built


def _run(command: Sequence[str], folder: str) -> None:
    """Run a compiler in a folder. Raises NotBuilt."""
    try:
        done = subprocess.run(command, cwd=folder, capture_output=True, check=False)
    except OSError as error:
        raise NotBuilt(f"{command[0]}: {error.strerror}") from None
    if done.returncode != 0:
        raise NotBuilt(f"{shlex.join(command)}\n{done.stderr.decode(errors='replace')}")


def is_supported() -> bool:
    """True if the core is meant for this machine: 64 bits, with the lowest byte first."""
    return sys.maxsize > 2**32 and sys.byteorder == "little" and platform.system() in ("Linux", "Darwin")


def platform_tag() -> str:
    """The platform of a wheel with the core: $FES_PLATFORM if the compiler builds for another one, or this one."""
    return os.environ.get("FES_PLATFORM") or sysconfig.get_platform().replace("-", "_").replace(".", "_")


def main() -> int:
    """Build in place; returns an exit code."""
    try:
        for library in build():
            print(library.relative_to(ROOT))
    except NotBuilt as reason:
        print(f"no core was built: {reason}")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
