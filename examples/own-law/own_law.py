"""A formation law of one's own: springs that saturate.

The paper's law pulls a robot by the sum of its separation errors. So a peer that is far away outweighs all near ones.
Here each link pulls like a spring, but never by more than `longest` meters.
"""

from typing import Any

import numpy as np

from fes.extension import Bools, Formed, LawContext, LinkGeometry, Neighborhood, Table


class SpringParameters(Table):
    """Parameters of the law, as keys of its table in a scenario. Unknown keys and wrong types are rejected."""

    gain: float = 0.5
    """Share of a small error that a robot corrects [1]."""
    longest: float = 10.0
    """Longest pull of one link [m]."""


class Saturated:
    """Each link pulls along its line of sight by gain * error / sqrt(1 + (error / longest)^2)."""

    Parameters = SpringParameters

    def __init__(self, parameters: SpringParameters, context: LawContext) -> None:
        self.gain, self.longest = parameters.gain, parameters.longest

    def start(self) -> Any:
        """The state before the first tick: this law remembers nothing."""
        return None

    def forget(self, state: Any, restarted: Bools) -> Any:
        """The state after some robots have restarted."""
        return state

    def step(self, state: Any, around: Neighborhood, links: LinkGeometry) -> Formed:
        """The pull of each robot [n, 2] [m; world frame], from the errors of its links [l]."""
        # `+ - * /` and `np.sqrt` have the same digits on every machine. For exp or sin, import `elementary`.
        pull = self.gain * links.error / np.sqrt(1.0 + (links.error / self.longest) ** 2)
        # `sum` adds the links of each robot in a fixed order, whichever robots share the process.
        x, y = (around.links.sum(pull * component) for component in links.bearing)
        return Formed(state, np.stack([x, y], axis=1))
