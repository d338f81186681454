"""Model-freeness of this process: without the channel's formula it cannot know the channel."""

import sys

FORMULA = ("agents.laws.oracle", "fes.model.outage")
"""Modules that know the channel's formula."""


def is_model_free() -> bool:
    """True if this process has loaded none of the modules that know the channel's formula."""
    return not any(name in sys.modules for name in FORMULA)
