"""One world per run directory: a lock of the operating system on it."""

import contextlib
import fcntl
import os
from collections.abc import Iterator
from pathlib import Path

from fes.errors import FesError, reason


@contextlib.contextmanager
def exclusive_lock(directory: Path) -> Iterator[None]:
    """Context in which no other world writes into this run directory; raises FesError if one does.

    The operating system locks the folder itself, and releases the lock however the process ends.
    """
    with contextlib.ExitStack() as held:
        try:
            folder = os.open(directory, os.O_RDONLY | os.O_DIRECTORY)
            held.callback(os.close, folder)
            fcntl.flock(folder, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except FileNotFoundError:
            pass  # no world can use a missing folder
        except BlockingIOError:
            raise FesError(f"another world is using {directory}") from None
        except OSError as error:
            raise FesError(f"cannot use the run directory: {reason(error)}") from None
        yield
