"""Headers of compiled libraries, made by hand from the formats' definitions (ELF-64, Mach-O 64)."""

import struct

import pytest

from deploy.wheels.libraries import needs


def elf(machine: int, strings: bytes) -> bytes:
    """An ELF header of 64 bits, with the lowest byte first, of a shared object (3), and a table of strings."""
    return b"\x7fELF\x02\x01\x01" + bytes(9) + struct.pack("<HH", 3, machine) + bytes(44) + strings


def macho(machine: int, *commands: bytes) -> bytes:
    """A Mach-O header of 64 bits of a dynamic library (6), and its load commands."""
    joined = b"".join(commands)
    return struct.pack("<8I", 0xFEEDFACF, machine, 0, 6, len(commands), len(joined), 0, 0) + joined


def oldest(version: int) -> bytes:
    """LC_BUILD_VERSION for macOS (1); the version is 16 bits, then 8 and 8 bits."""
    return struct.pack("<6I", 0x32, 24, 1, version, version, 0)


def named(name: bytes) -> bytes:
    """LC_ID_DYLIB, whose text begins 24 bytes after its start."""
    text = name + bytes(8 - len(name) % 8)
    return struct.pack("<6I", 0x0D, 24 + len(text), 24, 0, 0, 0) + text


SIGNATURE = struct.pack("<4I", 0x1D, 16, 0, 0)


@pytest.mark.parametrize(("number", "machine"), [(62, "x86_64"), (183, "aarch64")])
def test_the_newest_version_of_the_c_library_counts(number: int, machine: str) -> None:
    strings = b"\0memcpy\0libc.so.6\0GLIBC_2.2.5\0GLIBC_2.14\0GLIBC_2.9\0"
    assert needs(elf(number, strings))[:3] == ("linux", machine, (2, 14))


def test_a_library_that_calls_no_function_of_the_c_library_needs_no_version() -> None:
    assert needs(elf(62, b"\0fes_each_exp\0")).version == (0, 0)


def test_a_library_of_macos_has_its_version_name_and_signature_in_its_load_commands() -> None:
    signed = needs(macho(0x0100000C, named(b"librobots.so"), oldest(0x000B0000), SIGNATURE))
    assert signed == ("macos", "arm64", (11, 0), True, "librobots.so")
    assert needs(macho(0x01000007, oldest(0x000A0F02))) == ("macos", "x86_64", (10, 15), False, "")


@pytest.mark.parametrize(
    "content", [b"", b"\x7fELF\x01\x01", b"MZ" + bytes(100)], ids=["empty", "32 bits", "Windows"]
)
def test_any_other_file_is_rejected(content: bytes) -> None:
    with pytest.raises(ValueError, match="not a library of Linux or macOS"):
        needs(content)
