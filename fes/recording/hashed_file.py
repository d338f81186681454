"""Files that a run writes: hashed while they are written, and checked at the end for removal and truncation.

They are opened for appending. Writing at an offset would turn a truncation into a hole, which the size does not show.
"""

import hashlib
import os
import stat
from pathlib import Path


class HashedFile:
    """A new file, with the hash of all bytes written to it."""

    def __init__(self, path: Path, fileno: int | None = None) -> None:
        """`fileno` is the number of the file if it is open already; it is closed with this object."""
        self.path = path
        self._file = open(path if fileno is None else fileno, "wb", opener=append)  # noqa: SIM115
        self._hash = hashlib.sha256()
        self.size = 0
        """Number of bytes written."""

    @property
    def closed(self) -> bool:
        """True once the file is closed."""
        return self._file.closed

    @property
    def sha256(self) -> str:
        """SHA-256 of all bytes written, in hexadecimal."""
        return self._hash.hexdigest()

    def write(self, data: bytes) -> int:
        """Append bytes."""
        self._hash.update(data)
        self.size += len(data)
        return self._file.write(data)

    def tell(self) -> int:
        """The offset of the next byte."""
        return self.size

    def flush(self) -> None:
        """Hand all bytes written to the system."""
        self._file.flush()

    def fileno(self) -> int:
        """The number of the open file."""
        return self._file.fileno()

    def close(self) -> None:
        """Close the file."""
        self._file.close()


def append(path: str, flags: int) -> int:
    """Opener for `open`: every write appends to the file, wherever its end is then."""
    return os.open(path, flags | os.O_APPEND, 0o666)


def loss(path: Path, fileno: int, size: int) -> str | None:
    """Damage by other programs to a file after `size` bytes were written and flushed, in words; None without any.

    >>> import tempfile
    >>> with tempfile.NamedTemporaryFile(buffering=0) as file:
    ...     file.write(b"whole"), loss(Path(file.name), file.fileno(), 5), loss(Path(file.name), file.fileno(), 7)
    (5, None, 'was cut by 2 bytes')
    """
    ours = os.fstat(fileno)
    if not stat.S_ISREG(ours.st_mode):
        return None
    try:
        current = path.stat()
    except OSError:
        return "was removed"
    if (current.st_dev, current.st_ino) != (ours.st_dev, ours.st_ino):
        return "was replaced"
    if ours.st_size < size:
        return f"was cut by {size - ours.st_size:,} bytes"
    return (
        None if ours.st_size == size else f"was written to by another program: {ours.st_size:,} bytes, not {size:,}"
    )
