"""A log that never waits: a stopped terminal or a full pipe must not hold up a program that moves a robot."""

import logging
import logging.handlers
import queue
import time
from collections.abc import Callable

MOST = 256
"""Most lines that wait to be written; further ones are dropped."""


PAUSE = 0.005
"""Time between two looks at the lines that wait [s]."""


class _Dropping(logging.handlers.QueueHandler):
    """Hands a line to the writing thread, or drops it."""

    def enqueue(self, record: logging.LogRecord) -> None:
        try:
            self.queue.put_nowait(record)
        except queue.Full:
            self.dropped = getattr(self, "dropped", 0) + 1


def detach() -> Callable[[float], None]:
    """Let a thread of its own write all lines of this process from now on; it ends with the process.

    Returns a function that waits until all lines are written, for a time [s] at most.
    """
    root = logging.getLogger()
    waiting: queue.Queue[logging.LogRecord] = queue.Queue(MOST)
    listener = logging.handlers.QueueListener(waiting, *root.handlers)
    root.handlers = [_Dropping(waiting)]
    listener.start()

    def drain(seconds: float) -> None:
        end = time.monotonic() + seconds
        while waiting.unfinished_tasks and time.monotonic() < end:
            time.sleep(PAUSE)

    return drain
