"""Keys of a run, by the role that may publish on them."""

from collections.abc import Callable
from functools import partial

from fes.protocol import keys

WORLD: list[Callable[[str], str]] = [
    *(keys.world_alive, keys.report, keys.change, keys.about, keys.lease, keys.permit),
    partial(keys.claim, world="<id>"),
]


ROBOT = [
    *(keys.robot_alive, keys.observation, keys.beacon, keys.command, keys.recall),
    *(keys.gate_alive, keys.robot_report, keys.gate_start, keys.gate_stop, keys.gate_status),
]
