"""Keys of a run, by the role that may publish on them."""

from collections.abc import Callable
from functools import partial

from fes.protocol import keys

WORLD: list[Callable[[str], str]] = [
    *(keys.world_alive, keys.report, keys.change, keys.about, keys.lease),
    partial(keys.claim, world="<id>"),
]


ROBOT = [keys.robot_alive, keys.observation, keys.beacon, keys.command, keys.recall]
