"""The compiled libraries: which of them this process uses.

A library lies beside its bindings. It is used if it was built, if FES_CORE does not forbid it, and if it passes its
test: it must repeat the numpy code to the bit on samples whose results are stored. Otherwise numpy computes, with the
same digits.
"""

import ctypes
import os
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
        library = ctypes.CDLL(str(path))
        if not test(library):
            return None, "it computes other digits than numpy: it was compiled wrongly"
    except (OSError, AttributeError) as error:
        return None, f"it cannot be loaded ({error})"
    return library, C
