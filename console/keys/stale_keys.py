"""Private keys that a killed `fes run --secure` left behind.

`fes run` holds a lock on a file beside the keys of its run. The operating system
releases it however the process ends.
"""

import contextlib
import fcntl
import os
import shutil
from collections.abc import Iterator
from pathlib import Path

KEYS = "keys"
"""Folder of a run directory with the certificates and keys of its run."""

LOCK = "run.lock"
"""File that marks such a folder, locked during the run."""

PRIVATE = 0o600


@contextlib.contextmanager
def marked(directory: Path) -> Iterator[None]:
    """A block during which a folder of keys is locked; without the lock they count as stale. Raises OSError."""
    temporary = directory / f".{LOCK}"  # the file must never exist unlocked
    handle = os.open(temporary, os.O_WRONLY | os.O_CREAT, PRIVATE)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX)
        temporary.rename(directory / LOCK)
        yield
    finally:
        os.close(handle)


def stale(root: Path) -> list[Path]:
    """The folders of keys in run directories under `root` whose runs were killed."""
    return [path.parent for path in sorted(root.glob(f"*/{KEYS}/{LOCK}")) if _is_unlocked(path)]


def remove(root: Path) -> list[Path]:
    """Remove the stale folders under `root`; returns the removed ones."""
    removed = []
    for directory in stale(root):
        shutil.rmtree(directory, ignore_errors=True)
        if not directory.exists():
            removed.append(directory)
    return removed


def remark(directory: Path) -> str:
    """A remark on stale keys in a run directory; empty without any."""
    lock = directory / KEYS / LOCK
    return f"; {description(lock.parent)}" if lock.exists() and _is_unlocked(lock) else ""


def description(directory: Path) -> str:
    """Description of a stale folder of keys."""
    return f"{directory} has the private keys of a run that was killed"


def _is_unlocked(lock: Path) -> bool:
    """True if no process holds the lock."""
    if lock.parent.parent.is_symlink():  # runs/latest names a directory a second time
        return False
    try:
        handle = os.open(lock, os.O_WRONLY)
    except OSError:
        return False
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    finally:
        os.close(handle)
    return True
