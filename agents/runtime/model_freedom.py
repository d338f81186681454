"""Model-freeness of this process: without the channel's formula it cannot know the channel."""

import sys

from fes.arithmetic.core import library

FORMULA = ("agents.laws.oracle", "fes.model.outage")
"""Modules that know the channel's formula; a law that is told the channel loads the second."""

LIBRARIES = ("formula_index", "world")
"""Compiled libraries that know it."""


def is_model_free() -> bool:
    """True if this process has loaded no module and no compiled library that knows the channel's formula."""
    has_library = any(library.state.get(name) == library.C for name in LIBRARIES)
    return not has_library and not any(name in sys.modules for name in FORMULA)
