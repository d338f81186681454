"""The compiled libraries: which of them this process uses.

A library lies beside its bindings. It is used if it was built, if FES_CORE does not forbid it, and if it passes its
test: it must repeat the numpy code to the bit on samples whose results are stored. Otherwise numpy computes, with the
same digits.
"""

import ctypes
import os
import struct
from collections.abc import Callable, Collection
from pathlib import Path
from typing import Any, TypeAlias

from fes.errors import FesError

VARIABLE = "FES_CORE"
"""Environment variable: `c` demands the compiled core, `numpy` forbids it."""

SUFFIX = ".so"

C, NUMPY = "c", "numpy"

Buffer: TypeAlias = Any
"""An array of bytes of ctypes. Its address is known, and numpy arrays can lie in it; numpy has no type for it."""

NOT_BUILT = "it was not built"
"""Reason why numpy computes: the installation found no C compiler."""

_ELF = b"\x7fELF\x02\x01"
"""The first bytes of an ELF file of 64 bits, with the lowest byte first."""

_HEADER = 64
"""Length of its header [bytes]."""

_LOADED = 1
"""Type of a part of the file that is mapped."""

Test = Callable[[ctypes.CDLL], bool]
"""True if a library computes what it must."""

state: dict[str, str] = {}
"""Library -> `c`, or the reason why numpy computes instead; only of libraries that were asked for."""


def used(names: Collection[str]) -> bool:
    """True if this process computes with one of these libraries."""
    return any(state.get(name) == C for name in names)


def choice() -> str:
    """The value of FES_CORE, empty if unset. Raises FesError for any other word."""
    value = os.environ.get(VARIABLE, "")
    if value not in ("", C, NUMPY):
        raise FesError(f"{VARIABLE} must be '{C}' or '{NUMPY}', got {value[:60]!r}")
    return value


def load(module: str, name: str, test: Test) -> ctypes.CDLL | None:
    """The library `lib{name}` beside a module's file, if it passes its test; None if numpy computes.

    Raises FesError where FES_CORE demands a library that cannot be used.
    """
    wanted = choice()
    library: ctypes.CDLL | None = None
    if wanted == NUMPY:
        reason = f"{VARIABLE} is '{NUMPY}'"
    else:
        library, reason = _tested(Path(module).with_name(f"lib{name}{SUFFIX}"), test)
    if library is None and wanted == C:
        raise FesError(f"{VARIABLE} is '{C}', but the library '{name}' cannot be used: {reason}")
    state[name] = C if library is not None else reason
    return library


def _tested(path: Path, test: Test) -> tuple[ctypes.CDLL | None, str]:
    """The library of a file, or None and the reason."""
    if not path.exists():
        return None, NOT_BUILT
    try:
        if not _is_whole(path):
            return None, "its file is cut off"
        library = ctypes.CDLL(str(path))
        if not test(library):
            return None, "it computes other digits than numpy: it was compiled wrongly"
    except (OSError, AttributeError) as error:
        return None, f"it cannot be loaded ({error})"
    return library, C


def _is_whole(path: Path) -> bool:
    """False for an ELF file of 64 bits without all parts that are mapped: to load it would end this process."""
    data = path.read_bytes()
    if not data.startswith(_ELF) or len(data) < _HEADER:
        return not data.startswith(_ELF)
    start, (size, count) = struct.unpack_from("<Q", data, 32)[0], struct.unpack_from("<HH", data, 54)
    if start + size * count > len(data):
        return False
    segments = (struct.unpack_from("<IIQQQQ", data, start + size * index) for index in range(count))
    return all(kind != _LOADED or offset + length <= len(data) for kind, _, offset, _, _, length in segments)
