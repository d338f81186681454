"""Files from others: read with a bound on their size, or rejected in one line."""

import hashlib
import os
import stat
from pathlib import Path
from typing import Any, BinaryIO

from fes.errors import FesError, reason
from fes.system import strict_json

MAX_TABLE = 1 << 20
"""Largest size of a file that holds a table as JSON [bytes]."""

_BLOCK = 1 << 20  # bytes


def opened(path: Path) -> BinaryIO:
    """A regular file, open for reading; raises OSError, and FesError for a pipe or device, which may have no end."""
    if not stat.S_ISREG(path.stat().st_mode):  # checked first: open() waits for the writer of a pipe
        raise FesError(f"{path}: is not a regular file")
    return path.open("rb")


def read(path: Path, limit: int) -> bytes:
    """All of a regular file of at most `limit` bytes; raises FesError, and OSError where it cannot be read."""
    with opened(path) as file:
        fits = os.fstat(file.fileno()).st_size <= limit
        content = file.read(limit + 1) if fits else b""
    if not fits or len(content) > limit:
        raise FesError(f"{path}: is larger than {limit:,} bytes")
    return content


def sha256(path: Path, size: int) -> str:
    """SHA-256 of the first `size` bytes of a file, in hexadecimal; raises OSError."""
    digest = hashlib.sha256()
    with path.open("rb") as file:
        for start in range(0, size, _BLOCK):
            digest.update(file.read(min(_BLOCK, size - start)))
    return digest.hexdigest()


def read_table(path: Path, limit: int = MAX_TABLE) -> dict[str, Any]:
    """A file that holds one table as JSON; raises FesError."""
    try:
        table = strict_json.loads(read(path, limit))
    except OSError as error:
        raise FesError(f"{path} cannot be read: {reason(error, with_file=False)}") from None
    except ValueError as error:
        raise FesError(f"{path} cannot be read: it is not JSON: {error}") from None
    if not isinstance(table, dict):
        raise FesError(f"{path} cannot be read: it holds no table")
    return table
