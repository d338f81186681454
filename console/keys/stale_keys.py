"""Private keys that a killed `fes run --secure` left behind: found, named and removed.

The launcher holds a lock on a file beside the keys of its run. The system releases it however the launcher ends.
"""

import contextlib
import fcntl
import os
import shutil
from collections.abc import Iterator
from pathlib import Path

KEYS = "keys"
"""The folder of a run directory with the certificates and keys of its run."""

LOCK = "run.lock"
"""The file that marks this folder as that of one run; it is locked during the run."""

PRIVATE = 0o600


@contextlib.contextmanager
def marked(directory: Path) -> Iterator[None]:
    """A block that locks a folder of keys, which counts as left behind once this process is gone; raises OSError."""
    temporary = directory / f".{LOCK}"  # so that it never exists without its lock
    handle = os.open(temporary, os.O_WRONLY | os.O_CREAT, PRIVATE)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX)
        temporary.rename(directory / LOCK)
        yield
    finally:
        os.close(handle)


def found(root: Path) -> list[Path]:
    """The folders of keys in run directories under `root` whose runs are gone."""
    return [path.parent for path in sorted(root.glob(f"*/{KEYS}/{LOCK}")) if _is_left(path)]


def remove(root: Path) -> list[Path]:
    """Remove all that are `found` under `root`; returns those that are gone now."""
    removed = []
    for directory in found(root):
        shutil.rmtree(directory, ignore_errors=True)
        if not directory.exists():
            removed.append(directory)
    return removed


def named(directory: Path) -> str:
    """Remark on keys that are left in a run directory that cannot be used; empty if there are none."""
    lock = directory / KEYS / LOCK
    return f"; {left(lock.parent)}" if lock.exists() and _is_left(lock) else ""


def left(directory: Path) -> str:
    """Text about a folder of keys that was left behind."""
    return f"{directory} has the private keys of a run that was killed"


def _is_left(lock: Path) -> bool:
    """True if no process holds this lock."""
    if lock.parent.parent.is_symlink():  # runs/latest names a directory twice
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
