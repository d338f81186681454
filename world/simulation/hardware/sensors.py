"""The sensors of the robots' own poses: noise, drift, rate and latency.

A fix is the true pose at its tick, plus errors that depend on (seed, tick, robot) alone: so another rate or latency
draws no other errors. It arrives some ticks later, and a robot holds it until the next one arrives. Before tick 0 the
robots stood: each begins with a fix of tick 0.
"""

import math
from typing import NamedTuple

import numpy as np

from fes.arithmetic import draws, elementary
from fes.arrays import geometry
from fes.arrays.types import Bools, Floats, Ints
from fes.model import counts
from world.config.starts import SensingConfig
from world.simulation.hardware.normals import Normals


class Fixes(NamedTuple):
    """Fixes of all robots, and the ticks at which they were measured."""

    poses: Floats
    """[n, 3] [m, m, rad; world frame]."""
    ticks: Ints
    """[n]"""


class SensorState(NamedTuple):
    """The state of the sensors at one tick."""

    held: Fixes
    """The fixes that the robots have."""
    arriving: tuple[Fixes, ...]
    """Those on their way, by age: the first arrives at the next tick."""
    drift: Floats
    """Error of each coordinate that wanders [n, 2] [m]."""


class Sensors:
    """The constants of the sensors of a run."""

    def __init__(self, config: SensingConfig, seed: int, robots: int, dt: float) -> None:
        self._config = config
        self._latency = counts.ticks(config.pose_latency, dt)
        self._noise = Normals(seed, "pose noise", robots, 3)
        self._wandering = Normals(seed, "pose drift", robots, 2)
        [decay] = elementary.exp(np.array([-dt / config.pose_drift_time])).tolist()
        self._decay, self._step = decay, config.pose_drift * math.sqrt(1.0 - decay * decay)
        ids = np.arange(robots)
        # the ticks between two fixes need not be whole; a robot's own phase is a share of them
        self._period = 1.0 if config.pose_rate is None else max(1.0, counts.ratio(1.0 / config.pose_rate, dt))
        self._phase = self._period * draws.uniform_pairs(draws.key(seed, "pose phase"), ids, ids)

    def start(self, poses: Floats) -> SensorState:
        """The state at tick 0 of robots at `poses` [n, 3]."""
        drift = self._config.pose_drift * self._wandering.of(0)
        first = Fixes(self._measured(0, poses, drift), np.zeros(len(poses), dtype=np.int64))
        return SensorState(first, (first,) * self._latency, drift)

    def step(self, state: SensorState, tick: int, poses: Floats) -> SensorState:
        """The state at `tick`, one after that of `state`, with the robots at `poses` [n, 3]."""
        drift = state.drift
        if self._config.pose_drift > 0.0:
            drift = self._decay * drift + self._step * self._wandering.of(tick)
        newest, due = (state.arriving or (state.held,))[-1], self._due(tick)
        if due.any():
            measured = self._measured(tick, poses, drift)
            newest = Fixes(np.where(due[:, None], measured, newest.poses), np.where(due, tick, newest.ticks))
        arriving = (*state.arriving, newest)
        return SensorState(arriving[0], arriving[1:], drift)

    def _due(self, tick: int) -> Bools:
        """True for the robots that measure their pose at this tick [n]."""
        if self._period == 1.0:
            return np.ones(len(self._phase), dtype=np.bool_)
        due: Bools = np.floor((tick + self._phase) / self._period) > np.floor((tick - 1 + self._phase) / self._period)
        return due

    def _measured(self, tick: int, poses: Floats, drift: Floats) -> Floats:
        """The fixes [n, 3] of a tick."""
        config, result = self._config, poses.copy()
        noise = self._noise.of(tick) if config.pose_noise > 0.0 or config.heading_noise > 0.0 else None
        if config.pose_drift > 0.0:
            result[:, : geometry.HEADING] += drift
        if noise is not None and config.pose_noise > 0.0:
            result[:, : geometry.HEADING] += config.pose_noise * noise[:, : geometry.HEADING]
        if noise is not None and config.heading_noise > 0.0:
            turned = result[:, geometry.HEADING] + config.heading_noise * noise[:, geometry.HEADING]
            result[:, geometry.HEADING] = geometry.wrap(turned)
        return result


def of(config: SensingConfig, seed: int, robots: int, dt: float) -> Sensors | None:
    """The sensors of a run; None where each robot knows its true pose at each tick."""
    return None if config.is_exact else Sensors(config, seed, robots, dt)
