"""Clocks and global random numbers, made to raise: digits must depend only on the scenario and its seed.

Names that the modules of an extension imported before, such as `from time import time`, are replaced too. Other
threads of the process keep the originals.
"""

import datetime
import os
import random
import secrets
import sys
import threading
import time
import uuid
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from fes.errors import FesError

CLOCKS: tuple[tuple[Any, tuple[str, ...]], ...] = (
    (
        time,
        tuple(
            f"{name}{unit}"
            for name in ("time", "monotonic", "perf_counter", "process_time", "thread_time")
            for unit in ("", "_ns")
        ),
    ),
)
"""Modules, and their functions that read a clock."""

RANDOM: tuple[tuple[Any, tuple[str, ...]], ...] = (
    (random, ("SystemRandom",)),
    (random, tuple(name for name in random.__all__ if getattr(getattr(random, name), "__self__", None) is not None)),
    (np.random, tuple(name for name in np.random.__all__ if name.islower() and name != "default_rng")),
    (os, ("urandom", "getrandom")),
    (uuid, ("uuid1", "uuid4")),
    (secrets, ("token_bytes", "token_hex", "token_urlsafe", "randbelow", "randbits", "choice")),
)
"""Modules, and their functions that take global random numbers."""

UNSEEDED: tuple[tuple[Any, tuple[str, ...]], ...] = (
    (random, ("Random",)),
    (np.random, ("default_rng", "RandomState", "SeedSequence", "PCG64", "PCG64DXSM", "MT19937", "SFC64")),
    (time, ("localtime", "gmtime", "ctime")),
)
"""Modules, and their functions that do one of both if they are called without an argument."""


class Used(FesError):
    """An extension used a source that is not reproducible."""


@contextmanager
def forbidden(package: str, concerns: Callable[[str], bool] = lambda name: True) -> Iterator[list[str]]:
    """A block in which this thread's calls of a clock or of global randomness raise Used.

    Yields the names of the functions that were called. `package` is the top package of the extension. Only functions
    that the block `concerns`, by name, are replaced.
    """
    calls: list[str] = []
    replaced: dict[int, Any] = {}
    originals: list[tuple[Any, str, Any]] = []

    def put(owner: Any, name: str, replacement: Any) -> None:
        originals.append((owner, name, getattr(owner, name)))
        replaced[id(getattr(owner, name))] = replacement
        setattr(owner, name, replacement)

    guard = _Guard(calls, threading.get_ident())
    for table, is_allowed in ((CLOCKS, _never), (RANDOM, _never), (UNSEEDED, _with_argument)):
        for module, names in table:
            for name in names:
                if hasattr(module, name) and concerns(f"{module.__name__}.{name}"):
                    put(module, name, guard.around(getattr(module, name), f"{module.__name__}.{name}", is_allowed))
    for kind in (datetime.datetime, datetime.date) if concerns("datetime.datetime") else ():
        put(datetime, kind.__name__, guard.dated(kind))
    for module in [module for name, module in sys.modules.items() if name.partition(".")[0] == package]:
        for name, value in list(vars(module).items()):
            if id(value) in replaced:
                originals.append((module, name, value))
                setattr(module, name, replaced[id(value)])
    try:
        yield calls
    finally:
        guard.is_active = False  # for a module that was first imported within the block
        for owner, name, original in reversed(originals):
            setattr(owner, name, original)


class _Guard:
    """Replaces functions by ones that raise in one thread."""

    def __init__(self, calls: list[str], thread: int) -> None:
        self._calls, self._thread = calls, thread
        self.is_active = True

    def around(self, original: Any, name: str, is_allowed: Callable[..., bool]) -> Any:
        """A function or a class that raises unless a call of it is allowed."""
        if isinstance(original, type):
            return self._class(original, name, is_allowed)

        def guarded(*arguments: Any, **options: Any) -> Any:
            if self._forbids and not is_allowed(*arguments, **options):
                self._fail(name)
            return original(*arguments, **options)

        return guarded

    def dated(self, kind: Any) -> Any:
        """A class of dates, without the methods that read the clock."""
        names = [name for name in ("now", "utcnow", "today") if hasattr(kind, name)]
        members = {
            name: staticmethod(self.around(getattr(kind, name), f"datetime.{kind.__name__}.{name}", _never))
            for name in names
        }
        return type(kind.__name__, (kind,), members)

    def _class(self, original: Any, name: str, is_allowed: Callable[..., bool]) -> Any:
        """A class whose objects cannot be made by a call that is not allowed."""
        guarded = self.around(lambda *arguments, **options: None, name, is_allowed)

        def begin(instance: Any, *arguments: Any, **options: Any) -> None:
            guarded(*arguments, **options)
            original.__init__(instance, *arguments, **options)

        return type(original.__name__, (original,), {"__init__": begin})

    @property
    def _forbids(self) -> bool:
        return self.is_active and threading.get_ident() == self._thread

    def _fail(self, name: str) -> None:
        self._calls.append(name)
        raise Used(name)


def _never(*arguments: Any, **options: Any) -> bool:
    return False


def _with_argument(*arguments: Any, **options: Any) -> bool:
    return any(value is not None for value in [*arguments, *options.values()])
