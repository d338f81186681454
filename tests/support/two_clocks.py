"""A robot that hears one peer, whose clock drifts: arrivals with jitter, losses and repeats, in the order of time."""

import heapq
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from fes.protocol.messages import Beacon
from fes.protocol.sealed import Sealed
from field.senses.senses import Senses

NOTHING = np.zeros(0)
ROBOT, PEER, BOOT = 0, 1, 77


def beacon(tick: int, robot: int = PEER) -> Beacon:
    """A beacon without links, whose pose holds its tick."""
    none = NOTHING.astype(np.int64), NOTHING, NOTHING.astype(np.uint8), NOTHING
    return Beacon(tick, robot, (float(tick), 0.0, 0.0), *none)


@dataclass(frozen=True)
class Peer:
    """A peer's clock, and its way to the robot. Its step of tick j is at (j - `first`) (1 + `drift`) + `phase`."""

    phase: float = 0.0
    """[own ticks]"""
    first: int = 0
    drift: float = 0.0
    jitter: float = 0.0
    """Largest delay of a beacon [ticks]; delays are uniform."""
    loss: float = 0.0
    repeats: float = 0.0
    """Share of the beacons that arrive twice, within four ticks."""
    pause: float = 0.0
    """The network holds all beacons for so many ticks, once in 200 ticks."""

    def arrivals(self, count: int, seed: int) -> list[tuple[float, int]]:
        """Time [own ticks] and tick of each arrival of `count` beacons, in the order of time."""
        rng = np.random.default_rng(seed)
        ticks = np.arange(count)
        times = ticks * (1.0 + self.drift) + self.phase + self.jitter * rng.random(count)
        times = np.maximum(times, times // 200.0 * 200.0 + self.pause)
        arriving = rng.random(count) >= self.loss
        again = arriving & (rng.random(count) < self.repeats)
        later = times + 4.0 * rng.random(count)
        all_times = np.concatenate([times[arriving], later[again]])
        all_ticks = np.concatenate([ticks[arriving], ticks[again]]) + self.first
        order = np.argsort(all_times, kind="stable")
        return list(zip(all_times[order].tolist(), all_ticks[order].tolist(), strict=True))


def handed(senses: Senses, arrivals: list[tuple[float, int]], steps: int) -> Iterator[tuple[int, list[Beacon]]]:
    """Each step's tick and its beacons, from tick 1 on; an arrival at the very time of a step comes after it."""
    queue = list(arrivals)
    heapq.heapify(queue)
    for tick in range(1, steps):
        while queue and queue[0][0] < tick:
            at, sent = heapq.heappop(queue)
            senses.hear(Sealed(PEER, BOOT, sent, b""), beacon(sent), at)
        yield tick, senses.step(tick, (0.0, 0.0, 0.0), tick, 0)[1]
