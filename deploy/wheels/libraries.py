"""The machine and the oldest system that a compiled library needs, read from its header."""

import re
import struct
from typing import NamedTuple

ELF_MACHINES = {62: "x86_64", 183: "aarch64"}
MACHO_MACHINES = {0x01000007: "x86_64", 0x0100000C: "arm64"}

_NEEDED = re.compile(rb"GLIBC_(\d+)\.(\d+)")
"""Names of versions of the C library, in the table of strings."""

_HEADER, _COMMAND = struct.Struct("<8I"), struct.Struct("<2I")
_SIGNATURE, _INSTALL_NAME, _BUILD_VERSION = 0x1D, 0x0D, 0x32
"""Load commands of macOS."""


class Needs(NamedTuple):
    """The needs of a library."""

    system: str
    machine: str
    version: tuple[int, int]
    """The oldest C library on Linux; the oldest macOS."""
    is_signed: bool
    """True if macOS finds a signature, which it demands on arm64."""
    name: str
    """The name that macOS gives the library; empty on Linux."""


def needs(content: bytes) -> Needs:
    """The needs of a library, by the content of its file. Raises ValueError for anything else."""
    if content[:6] == b"\x7fELF\x02\x01":
        versions = [(int(major), int(minor)) for major, minor in _NEEDED.findall(content)]
        machine = ELF_MACHINES.get(struct.unpack_from("<H", content, 18)[0], "an unknown machine")
        return Needs("linux", machine, max(versions, default=(0, 0)), False, "")
    if content[:4] == b"\xcf\xfa\xed\xfe":
        return _of_macos(content)
    raise ValueError("not a library of Linux or macOS with 64 bits")


def _of_macos(content: bytes) -> Needs:
    """The needs by the load commands."""
    _, kind, _, _, commands, *_ = _HEADER.unpack_from(content)
    version, is_signed, name, place = (0, 0), False, "", _HEADER.size
    for _ in range(commands):
        command, size = _COMMAND.unpack_from(content, place)
        if command == _BUILD_VERSION:
            (packed,) = struct.unpack_from("<I", content, place + 12)
            version = packed >> 16, packed >> 8 & 0xFF
        elif command == _INSTALL_NAME:
            (start,) = struct.unpack_from("<I", content, place + 8)
            name = content[place + start : place + size].rstrip(b"\0").decode()
        is_signed = is_signed or command == _SIGNATURE
        place += size
    return Needs("macos", MACHO_MACHINES.get(kind, "an unknown machine"), version, is_signed, name)
