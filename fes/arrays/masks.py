"""Short masks, one element per robot, which most ticks ask whether all robots take part."""

from fes.arrays.types import Bools


def is_full(mask: Bools) -> bool:
    """True if no element of a mask is false; for a short mask several times as fast as numpy's `all`.

    >>> import numpy as np
    >>> is_full(np.array([True, False])), is_full(np.ones(3, np.bool_))
    (False, True)
    """
    return 0 not in mask.tobytes()
