"""The platforms of a release: the tag of each wheel, and the compiler's name of the platform.

One compiler builds for all of them: zig, a C compiler (clang) with the C libraries of all platforms, from the Python
Package Index. It takes the version of the C library as a part of the platform's name.
"""

import shlex
from typing import NamedTuple

ZIG = "ziglang==0.17.*"
"""The compiler, as a requirement."""

GLIBC = (2, 17)
"""The oldest C library of Linux that is supported: that of manylinux2014."""

MACOS = (11, 0)
"""The oldest macOS."""


class Platform(NamedTuple):
    """A system and a machine."""

    system: str
    machine: str
    """As in the tags."""
    tags: tuple[str, ...]
    """Platform tags of its wheel."""
    target: str
    """Zig's name."""

    @property
    def name(self) -> str:
        """The name as a word of the command."""
        return f"{self.system}-{self.machine}"

    def compiler(self, python: str) -> str:
        """The value of CC: a compiler for the platform, started by a Python that has zig."""
        return shlex.join([python, "-m", "ziglang", "cc", "-target", self.target, "-s"])


def _linux(machine: str) -> Platform:
    glibc = "{}.{}".format(*GLIBC)
    tags = f"manylinux_{glibc.replace('.', '_')}_{machine}", f"manylinux2014_{machine}"
    return Platform("linux", machine, tags, f"{machine}-linux-gnu.{glibc}")


def _macos(machine: str, target: str) -> Platform:
    return Platform("macos", machine, ("macosx_{}_{}_{}".format(*MACOS, machine),), target)


PLATFORMS = {
    platform.name: platform
    for platform in (
        _linux("x86_64"),
        _linux("aarch64"),
        _macos("x86_64", "x86_64-macos.{}.{}".format(*MACOS)),
        _macos("arm64", "aarch64-macos.{}.{}".format(*MACOS)),
    )
}
"""Platforms with a compiled core, by name."""

ANY, SOURCE = "any", "source"
"""The wheel without a core, for every other platform, and the source distribution."""
