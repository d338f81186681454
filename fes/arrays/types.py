"""Type aliases for the arrays in signatures, and read-only views."""

from typing import Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

Floats: TypeAlias = NDArray[np.float64]
Ints: TypeAlias = NDArray[np.int64]
Bools: TypeAlias = NDArray[np.bool_]
Bytes: TypeAlias = NDArray[np.uint8]

A = TypeVar("A", bound=NDArray[Any])


def read_only(values: A) -> A:
    """The same values in an array that cannot be written to: what is handed to extensions."""
    view = values.view()
    view.setflags(write=False)
    return view
