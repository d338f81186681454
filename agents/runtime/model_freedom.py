"""Model-freeness of this process: without the channel's formula it cannot know the channel."""

import sys

from fes.model.config import ChannelConfig

FORMULA = ("agents.laws.oracle", "fes.model.outage")
"""Modules that know the channel's formula."""


def is_model_free(channel: ChannelConfig | None) -> bool:
    """True if this process was not told a `channel`, and has loaded no module that knows the channel's formula."""
    return channel is None and not any(name in sys.modules for name in FORMULA)
