"""The self-test of the robots' kernels: some ticks of small crews, whose results are known."""

import ctypes
import hashlib
import math
from ctypes import addressof

import numpy as np

from agents.core.structures import BeaconArrays, Constants, Input
from fes.arrays.types import Bytes, Floats

EXPECTED = "47f15febbdab"
"""Hash of the results."""

_ROBOTS, _TICKS = 6, 12

_CASES = ((0, 1), (1, 1), (2, 2), (2, 3))
"""Neighbor rule and seeking law of each crew: all laws but the oracle's, whose index is not here."""


def digest(library: ctypes.CDLL) -> str:
    """Hash of the last state of each crew."""
    result = hashlib.sha256()
    for rule, seeking in _CASES:
        result.update(_last(library, _constants(rule, seeking)))
    return result.hexdigest()[:12]


def _constants(rule: int, seeking: int) -> Constants:
    """A crew that keeps a safe separation, with numbers of the usual magnitudes."""
    constants = Constants(
        robots=_ROBOTS,
        dt=0.02,
        timeout=50,
        rule=rule,
        tolerance=0.1,
        seeking=seeking,
        statistics=5 if seeking == 2 else 0,
        low_estimate=50.0,
        high_estimate=90.0,
        dither_amplitude=0.2,
        dither_frequency=100.0,
        consensus_gain=4.0,
        extrapolates=1,
        sub_steps=1,
        index_gain=40000.0,
        linear_gain=1.0,
        angular_gain=10.0,
        linear_limit=5.0,
        angular_limit=math.inf,
        safe_separation=30.0,
        separation_gain=0.1,
        give_way_gain=1.0,
    )
    constants.objective.minimum_separation, constants.objective.maximum_separation = 50.0, 150.0
    constants.objective.shape_exponent, constants.objective.share_of_reach = 4.0, 1.0 / 81.0
    method = constants.method
    method.short_share, method.long_share, method.gain, method.scale = 0.998, 0.9998, 0.3, 75.0
    method.slope_prior[:], method.slopes[:] = (0.025, 0.01), (0.5, 8.0)
    for step in (constants.coupled, constants.alone):
        numbers = np.frombuffer(step, dtype=np.float64)  # a view: the response matrices are those of no real filter
        numbers[:] = np.arange(len(numbers)) % 7 / 1024.0
    return constants


def _last(library: ctypes.CDLL, constants: Constants) -> bytes:
    """The numbers that a crew sends at its last tick, and its twists."""
    n = _ROBOTS
    ids, others = np.arange(n), np.arange(n * (n - 1))
    peers = others % (n - 1) + (others % (n - 1) >= others // (n - 1))
    arrays = (ids, 0 * ids, np.arange(2 * n), np.arange(2 * n) + 7, np.arange(n + 1) * (n - 1), peers)
    constants.ids, constants.first, constants.estimate_keys, constants.stagger_keys, begin, in_range = (
        array.ctypes.data for array in arrays
    )
    places = (ctypes.c_int64 * 64)()
    capacity = n * (n - 1)
    length = library.fes_crew_layout(addressof(constants), capacity, places)
    before: Bytes = np.zeros(length, np.uint8)
    before.view(np.int64)[3 * n : 5 * n] = 2**62  # no robot has taken part, or had a link
    scratch = np.zeros(2 * n + capacity)
    twists, sent_poses, sent_statistics, selected, sent = (places[index] for index in (27, 28, 29, 30, 31))
    link_begin, link_peers = places[18], places[20]
    given = Input(begin=begin, in_range=in_range)
    count = 0
    for tick in range(_TICKS):
        poses = _poses(tick)
        reception = (((others + tick) % 5 > 0) * 2).astype(np.uint8)
        given.tick, given.poses, given.reception = tick, poses.ctypes.data, reception.ctypes.data
        after = np.zeros(length, np.uint8)
        a, b = before.ctypes.data, after.ctypes.data
        given.beacons = BeaconArrays(
            n * (tick > 0),
            constants.ids,
            *(a + place for place in (sent_poses, link_begin, link_peers, sent, selected, sent_statistics)),
        )
        library.fes_crew_tick(addressof(constants), addressof(given), a, capacity, b, capacity, scratch.ctypes.data)
        before = after
        count = int(before[link_begin : link_begin + 8 * (n + 1)].view(np.int64)[n])
    spans = (twists, 16 * n), (sent_poses, 24 * n), (sent, 8 * count)
    return b"".join(before[place : place + size].tobytes() for place, size in spans)


def _poses(tick: int) -> Floats:
    """Poses of robots that drift, so that neighbors and near peers change [n, 3]."""
    robots = np.arange(_ROBOTS)
    x, y = 40.0 * (robots % 3) + 0.5 * tick * robots, 55.0 * (robots // 3) - 0.25 * tick * (robots % 2)
    return np.stack([x, y, 0.5 * robots - 1.0 + 0.125 * tick], axis=1)
