"""Builds the compiled core: four small libraries in C that repeat the numpy code to the bit.

`pip install` calls it through hatch_build.py. From a clone, `python build_core.py` builds the libraries in place.
It imports nothing but the standard library: it runs before the dependencies are installed.
"""

import os
import platform
import shutil
import subprocess
import sys
import sysconfig
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


def compiler() -> str | None:
    """The C compiler: $CC, or the first of cc, gcc and clang on the path; None without one."""
    if named := os.environ.get("CC"):
        return named
    return next((name for name in ("cc", "gcc", "clang") if shutil.which(name)), None)


def libraries(root: Path = ROOT) -> dict[Path, list[Path]]:
    """Each library of a tree, and its C files."""
    return {
        root / f"{name}{SUFFIX}": sorted(file for folder in folders for file in (root / folder).glob("*.c"))
        for name, folders in LIBRARIES.items()
    }


def build(command: Sequence[str], root: Path = ROOT, into: Path | None = None) -> list[Path]:
    """Compile all libraries of a tree by `command`, a compiler and further flags; returns their files.

    They come into their packages, or under the folder `into`. Raises OSError or subprocess.CalledProcessError.
    """
    built = []
    for library, sources in libraries(root).items():
        if not sources:
            continue
        target = library if into is None else into / library.relative_to(root)
        target.parent.mkdir(parents=True, exist_ok=True)
        fresh = target.with_suffix(f".{os.getpid()}")  # a process that has the old library open keeps it
        try:
            subprocess.run(
                [*command, *FLAGS, f"-I{root}", "-o", str(fresh), *map(str, sources)], check=True, capture_output=True
            )
            fresh.replace(target)
        finally:
            fresh.unlink(missing_ok=True)
        built.append(target)
    return built


def is_supported() -> bool:
    """True if the core is meant for this machine: 64 bits, with the lowest byte first."""
    return sys.maxsize > 2**32 and sys.byteorder == "little" and platform.system() in ("Linux", "Darwin")


def platform_tag() -> str:
    """The platform of a wheel with the core: $FES_PLATFORM where the compiler is for another one, or this one."""
    return os.environ.get("FES_PLATFORM") or sysconfig.get_platform().replace("-", "_").replace(".", "_")


def main() -> int:
    """Build in place; returns an exit code."""
    cc = compiler()
    if cc is None or not is_supported():
        print(
            "no core was built: " + ("no C compiler was found" if cc is None else "it is not meant for this machine")
        )
        return 1
    try:
        for library in build(cc.split()):
            print(library.relative_to(ROOT))
    except subprocess.CalledProcessError as error:
        print(f"no core was built: {error.stderr.decode(errors='replace')}")
        return 1
    except OSError as error:
        print(f"no core was built: {error}")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
