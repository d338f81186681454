"""Completed work, as a function that the work calls: no terminal, no clock."""

from collections.abc import Callable
from functools import partial
from itertools import accumulate

Watch = Callable[[int], None]
"""Called repeatedly with the number of completed units, such as ticks, up to the total."""


def ignore(done: int) -> None:
    """A Watch that does nothing."""


def parts(watch: Watch, *totals: int) -> list[Watch]:
    """A Watch for each part of the work, which continues from the totals of the parts before it.

    >>> counts: list[int] = []
    >>> first, second = parts(counts.append, 10, 5)
    >>> first(10), second(2)
    (None, None)
    >>> counts
    [10, 12]
    """
    return [partial(_on, watch, before) for before in accumulate((0, *totals[:-1]))]


def _on(watch: Watch, before: int, done: int) -> None:
    watch(before + done)
