"""The shape that a configuration asks for, by its name and the number of robots."""

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from fes.arrays.types import Floats
from fes.shapes import drawn
from fes.shapes.patch import patch
from fes.shapes.shape import Shape, of_slots

Offsets = tuple[tuple[float, float], ...]

DRAWN: dict[str, Callable[[int], Floats]] = {"line": drawn.line, "ring": drawn.ring, "ladder": drawn.ladder}


@lru_cache(maxsize=512)
def shape(name: str, n: int, losses: int, offsets: Offsets = ()) -> Shape:
    """The shape `name` of `n` >= 1 robots: `lattice`, one of DRAWN, or `offsets`, of which the first `n` are used.

    `losses` is 0 or 1 and chooses among patches of the lattice. Raises ValueError for fewer than `n` offsets.
    """
    if name == "offsets":
        if len(offsets) < n:
            raise ValueError(f"{n} robots need {n} offsets, got {len(offsets)}")
        return of_slots(np.array(offsets[:n], dtype=np.float64))
    return of_slots(DRAWN[name](n)) if name in DRAWN else patch(n, losses)
