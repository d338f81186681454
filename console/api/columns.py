"""Columns of values as numpy arrays, and as data frames of pandas, which comes with the extra `notebook`."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fes.errors import FesError
from fes.system.distribution import install

if TYPE_CHECKING:
    from pandas import DataFrame

Column = NDArray[Any]


def frame(columns: Mapping[str, Column]) -> "DataFrame":
    """A data frame of pandas with these columns; raises FesError if pandas is not installed."""
    try:
        import pandas
    except ImportError:
        raise FesError(f"frame() needs pandas: {install('notebook')}") from None
    return pandas.DataFrame(dict(columns))


def column(values: Sequence[Any], is_text: bool = False) -> Column:
    """Values as an array of the narrowest type of all: bool, int64 or float64; otherwise, and for text, objects.

    A missing number is NaN, a missing text None.

    >>> column([1, 2]), column([1, None]), column(["a", None])
    (array([1, 2]), array([ 1., nan]), array(['a', None], dtype=object))
    """
    kinds = {type(value) for value in values}
    if kinds == {bool}:
        return np.array(values, dtype=np.bool_)
    if kinds == {int}:
        return np.array(values, dtype=np.int64)
    if not is_text and kinds <= {int, float, bool, type(None)}:
        return np.array([np.nan if value is None else value for value in values], dtype=np.float64)
    return np.array([*values, None], dtype=object)[:-1]  # lists, too, are single objects
