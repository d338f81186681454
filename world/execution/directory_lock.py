"""One world per run directory: the system's lock on it."""

import contextlib
import fcntl
import os
from collections.abc import Iterator
from pathlib import Path

from fes.errors import FesError, reason


@contextlib.contextmanager
def exclusive_lock(directory: Path) -> Iterator[None]:
    """Block in which no other world writes into this run directory; raises FesError if one does.

    The system's lock is on the folder itself, and ends with the process, however that ends.
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
