"""Extremum seeking of each link by itself, after Krstic & Wang, "Stability of extremum seeking feedback" (2000).

The dither is physical: robots drive to r_hat + a sin(omega t). The sample of J of (16) at a tick is S(r) if the
beacon decoded, else 0, so its mean is J(r). It passes a washout, the product with sin(omega t), a low-pass and an
integrator, whose output is r_hat. Both ends of a link measure alone. A consensus term, which Krstic and Wang do not
need, keeps the two from chasing each other.
"""

import math
from typing import Annotated

import numpy as np
from pydantic import Field

from fes.extension import (
    Bools,
    Edges,
    Entry,
    Floats,
    Formed,
    LawContext,
    Neighborhood,
    NonNegative,
    Positive,
    Published,
    Table,
    elementary,
    preference,
)

ESTIMATE, BASELINE, SLOPE = 0, 1, 2
"""Rows of the state [3, l]: r_hat [m], the washout's baseline [1], and the low-passed product [1]."""

FIRST_ESTIMATE = "krstic_wang: first estimate"
"""Stream of random numbers."""


class KrsticWangParameters(Table):
    """The parameters of `krstic_wang`."""

    dither_amplitude: Positive = 5.0
    """Amplitude of the dither [m] (a)."""
    dither_frequency: Positive = 2.0 * math.pi / 20.0
    """Frequency of the dither [rad/s] (omega)."""
    washout_cutoff: Annotated[float, Field(gt=0, le=10)] = 0.1
    """Cut-off of the washout filter [rad/s] (omega_h)."""
    low_pass_cutoff: Annotated[float, Field(gt=0, le=10)] = 0.2
    """Cut-off of the low-pass filter [rad/s] (omega_l)."""
    gain: Positive = 10.0
    """Gain of the integrator [m/s] (k)."""
    consensus_gain: Annotated[float, Field(ge=0, le=10)] = 1.0
    """Gain toward the peer's estimate of the same link [1/s]."""
    initial_estimate: tuple[Positive, Positive] = Field(default=(50.0, 90.0), strict=False)
    """Interval from which the first estimates are drawn uniformly [m]."""
    fastest: NonNegative = 5.0
    """Largest speed of an estimate, consensus aside [m/s]."""


class KrsticWang:
    """The seeking law; its state is [3, l]."""

    Parameters = KrsticWangParameters
    knows_channel = False
    statistics = 0
    declared = 0
    learnt = ("slope",)

    def __init__(self, parameters: KrsticWangParameters, context: LawContext) -> None:
        self._parameters, self._context = parameters, context
        self._nothing = np.zeros((len(context.ids), 0))

    @staticmethod
    def physical_period(parameters: KrsticWangParameters) -> float:
        """Period of the dither [s]."""
        return 2.0 * math.pi / parameters.dither_frequency

    def start(self) -> Floats:
        """No link."""
        return np.zeros((3, 0))

    def forget(self, state: Floats, restarted: Bools, old: Edges, new: Edges) -> Floats:
        """The state of the links that remain."""
        return new.carry(state, old, 0.0, axis=1)

    def relink(self, state: Floats, old: Edges, new: Edges, entry: Entry) -> Floats:
        """The state over the links `new`. A new link begins with the mean estimate of its robot, or with a draw."""
        transition = new.after(old)
        result, is_new = transition.carry(state, 0.0, axis=1), transition.is_new
        if is_new.any():
            begun = new.select(is_new)
            first = (old.sum(state[ESTIMATE]) / np.maximum(old.counts, 1)).take(begun.rows)
            is_drawn = (entry.is_fresh | (old.counts == 0)).take(begun.rows)
            if is_drawn.any():
                first[is_drawn] = self._drawn(begun.select(is_drawn))
            result[ESTIMATE, is_new] = first
            result[BASELINE, is_new] = preference(first, self._context.objective)
        return result

    def _drawn(self, links: Edges) -> Floats:
        """Seeded first estimates [l] [m]."""
        low, high = self._parameters.initial_estimate
        return low + (high - low) * self._context.draws(FIRST_ESTIMATE, links.robots, links.peers)

    def desired(self, state: Floats, tick: int, links: Edges) -> Floats:
        """The estimates with the dither [l] [m]."""
        desired: Floats = state[ESTIMATE] + self._parameters.dither_amplitude * self._wave(tick, links)
        return desired

    def measure(self, state: Floats, around: Neighborhood, formed: Formed) -> Floats:
        """The filters after the beacons of the previous tick."""
        dt, parameters = self._context.dt, self._parameters
        separation = around.contacts.separation.take(around.link_contact)
        is_heard = around.is_heard.take(around.link_contact)
        sample = np.where(is_heard, preference(separation, self._context.objective), 0.0)
        baseline = state[BASELINE] + dt * parameters.washout_cutoff * (sample - state[BASELINE])
        product = (sample - baseline) * self._wave(around.tick - 1, around.links)
        slope = state[SLOPE] + dt * parameters.low_pass_cutoff * (product - state[SLOPE])
        return np.stack([state[ESTIMATE], baseline, slope])

    def publish(self, state: Floats, links: Edges) -> Published:
        """The estimates, and the low-passed products for observers."""
        return Published(state[ESTIMATE], self._nothing, state[SLOPE][None, :])

    def seek(self, state: Floats, around: Neighborhood) -> Floats:
        """The estimates one tick later."""
        parameters, peers, objective = self._parameters, around.peer_estimates, self._context.objective
        speed = np.clip(parameters.gain * state[SLOPE], -parameters.fastest, parameters.fastest)
        speed += parameters.consensus_gain * np.where(np.isfinite(peers), peers - state[ESTIMATE], 0.0)
        low, high = 0.4 * objective.minimum_separation, objective.maximum_separation
        estimates = np.clip(state[ESTIMATE] + self._context.dt * speed, low, high)
        return np.stack([estimates, state[BASELINE], state[SLOPE]])

    def _wave(self, tick: int, links: Edges) -> Floats:
        """sin(omega t) on the clock of each link's robot [l]."""
        time = tick * self._context.dt + self._context.skew(tick, links)
        return np.broadcast_to(elementary.sin_cos(self._parameters.dither_frequency * time)[0], (len(links),))
