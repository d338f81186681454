"""The self-test of the world's kernels: some ticks of a few robots, whose results are known."""

import ctypes
import hashlib
from ctypes import addressof

import numpy as np

from fes.arrays.edges import Edges
from world.simulation.core.link_kernels import LinkKernels
from world.simulation.core.structures import DRAWN, TOTALS, CandidateList, Input, Layout, Settings

EXPECTED = "58d1b5362386"
"""Hash of the results."""

_ROBOTS, _TICKS = 8, 10


def digest(library: ctypes.CDLL) -> str:
    """Hash of the poses, separations and contacts at the last tick, over two channels; and of the errors of links."""
    result = hashlib.sha256()
    for model in (0, 1):
        result.update(_last(library, Settings(0.02, 120.0, model, 0, 4e-7, 3.0, 80.0, 12.0, 12, 34)))
    result.update(_links(library))
    return result.hexdigest()[:12]


def _last(library: ctypes.CDLL, settings: Settings) -> bytes:
    n = _ROBOTS
    robots, present = np.arange(n), np.ones(n, np.uint8)
    a, b = np.triu_indices(n, 1)
    layout = Layout(library, n, len(a))
    before = layout.buffer()
    layout.view(before, "totals", TOTALS)[DRAWN] = -1
    poses = layout.view(before, "poses", (n, 3))
    poses[:] = np.stack([45.0 * (robots % 4), 60.0 * (robots // 4), 0.5 * robots], axis=1)
    twists = np.stack([2.0 + robots, 0.25 * robots - 1.0], axis=1)
    listed = CandidateList(len(a), a.ctypes.data, b.ctypes.data, None, 0.0)
    given = Input(n, 0, 0, twists.ctypes.data, present.ctypes.data, None, listed, listed)
    for tick in range(_TICKS):
        after = layout.buffer()
        given.tick, given.poses = tick, addressof(before) + layout.places["poses"]
        library.fes_world_tick(addressof(settings), addressof(given), addressof(before), addressof(after))
        before = after
    pairs = int(layout.view(before, "begin", n + 1)[n])
    shapes = {"poses": 3 * n, "separation": len(a), "decoded": pairs, "peers": pairs, "outage_sum": pairs}
    return b"".join(layout.view(before, name, shape).tobytes() for name, shape in shapes.items())


def _links(library: ctypes.CDLL) -> bytes:
    kernels = LinkKernels(library)
    robots = np.arange(_ROBOTS)
    near, far = (robots + 1) % _ROBOTS, (robots + 3) % _ROBOTS
    peers = np.stack([np.minimum(near, far), np.maximum(near, far)], axis=1)
    links = Edges(robots, np.repeat(robots, 2), peers.ravel())
    poses = np.stack([45.0 * robots, 7.0 * robots * robots, 0.0 * robots], axis=1)
    separation = kernels.separations(links, poses)
    estimates = np.arange(60.0, 60.0 + len(links))
    numbers = kernels.errors(links, estimates, separation, 66.6)
    return separation.tobytes() + np.array(numbers).tobytes()
