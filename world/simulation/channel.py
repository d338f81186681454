"""The radio: the fate of each beacon at each robot in range.

Every robot sends a beacon at every tick. A robot in range decodes it with the reception probability of the channel
between the two at that tick. Without bursts, ticks and directions are independent (block fading). A contact opens two
ticks after the robots came in range.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fes.arithmetic import draws, elementary
from fes.arrays import geometry, masks
from fes.arrays.edges import Edges, no_edges
from fes.arrays.types import Bools, Bytes, Floats, Ints
from fes.extension.context import WorldContext
from fes.model.sensing import CLOSED, OPENING_TICKS
from world.config.radio import JammerConfig, RadioConfig, ShadowingConfig
from world.simulation import bursts, shadowing
from world.simulation.draw_cache import DrawCache
from world.simulation.neighbor_list import Proximity
from world.simulation.reception import Reception

Array = NDArray[Any]

_FARTHEST = 100.0  # largest shift of an effective separation by shadowing [powers of ten]: numbers stay finite


@dataclass(frozen=True, eq=False)
class Medium:
    """The random numbers of the radio of a run: functions of the seed, independent of the channel's settings."""

    dt: float
    """Tick length [s]."""
    fading: DrawCache
    bursts: DrawCache
    seed: int
    reception: Reception

    @cached_property
    def waves(self) -> shadowing.Modes:
        """The waves of the shadowing, made when a channel first has any."""
        return shadowing.modes(self.seed)


@dataclass(frozen=True, eq=False)
class Radio:
    """The result of one tick of the radio, over the pairs in range [m], and the ledger of each contact."""

    edges: Edges
    """The pairs (receiver, sender) in range [m]."""
    age: Ints
    """Ticks since each pair came in range [m]."""
    reception: Bytes
    """Fate of the previous tick's beacon: CLOSED (0), LOST (1) or DECODED (2) [m]."""
    sent: Ints
    """Beacons sent on each contact since it opened [m]."""
    decoded: Ints
    """Beacons decoded on it [m]."""
    probability: Floats
    """True reception probability of the previous tick's beacon, with shadowing, jammers and faults, and with the mean
    factor of the bursts; NaN before the first beacon [m]."""
    outage_sum: Floats
    """Sum of 1 - probability over the beacons sent: the expected number of lost ones [m]."""
    gap: Ints
    """Beacons lost in a row until now [m]."""
    longest_gap: Ints
    """The largest `gap` since the contact opened [m]."""
    burst: Bytes
    """GOOD, BAD or UNKNOWN, for the previous tick's beacon; unchanged while the channel has no bursts [m]."""


_NO_INTS: Ints = np.zeros(0, dtype=np.int64)
_NO_CODES: Bytes = np.zeros(0, dtype=np.uint8)
_NO_NUMBERS: Floats = np.zeros(0)
_NO_LEDGER = Radio(
    no_edges(_NO_INTS),
    age=_NO_INTS,
    reception=_NO_CODES,
    sent=_NO_INTS,
    decoded=_NO_INTS,
    probability=_NO_NUMBERS,
    outage_sum=_NO_NUMBERS,
    gap=_NO_INTS,
    longest_gap=_NO_INTS,
    burst=_NO_CODES,
)


def medium(seed: int, context: WorldContext) -> Medium:
    """The medium of a run with `seed`."""
    fading, states = (DrawCache(draws.key(seed, stream)) for stream in ("channel", "bursts"))
    return Medium(context.dt, fading, states, seed, Reception(context))


def quiet(edges: Edges) -> Radio:
    """The radio before the first tick: every pair has just come in range, and no beacon was sent."""
    return _converted(_NO_LEDGER, edges, edges.after(_NO_LEDGER.edges).carry)


@dataclass(frozen=True, eq=False)
class RadioInput:
    """The state of the robots at one tick, as far as it determines which beacons decode."""

    tick: int
    poses: Floats
    """[n, 3] [m, m, rad; world frame]"""
    present: Bools
    """Robots that take part [n]; the others neither send nor receive."""
    proximity: Proximity
    reception_factor: Floats | None = None
    """Factor of each robot's own transmitter on the reception probability [n]; None where all are healthy."""


def transmit(medium: Medium, config: RadioConfig, radio: Radio, robots: RadioInput, after: Edges) -> Radio:
    """The radio one tick later, over the pairs `after` that are then in range.

    The peers of a robot that takes no part get the code LOST, but no beacon was sent.
    """
    before, present, factor = robots.proximity, robots.present, robots.reception_factor
    edges, age = before.edges, radio.age + 1
    is_open = age >= OPENING_TICKS
    on_air = is_open if masks.is_full(present) else is_open & among(edges, present)
    probability = reception_probability(medium, config, robots, before)
    if factor is not None:
        probability = probability * factor.take(_senders(edges))
    average, burst = probability, radio.burst
    if config.bursts is not None:
        burst = bursts.step(burst, config.bursts, medium.dt, medium.bursts.numbers(robots.tick, edges))
        average = probability * bursts.mean_reception_factor(config.bursts)
        probability = probability * bursts.reception_factor(burst, config.bursts)
    is_decoded = on_air
    if factor is not None or not config.is_certain:
        is_decoded = on_air & (medium.fading.numbers(robots.tick, edges) < probability)
    gap = (radio.gap + 1) * (on_air ^ is_decoded)
    now = Radio(
        edges,
        age,
        np.add(is_open, is_decoded, dtype=np.uint8),  # CLOSED, LOST and DECODED count the two
        radio.sent + on_air,
        radio.decoded + is_decoded,
        average,
        radio.outage_sum + (1.0 - average) * on_air,
        gap,
        np.maximum(radio.longest_gap, gap),
        burst,
    )
    return now if after is edges else _converted(now, after, after.after(edges).carry)


def reception_probability(medium: Medium, config: RadioConfig, robots: RadioInput, near: Proximity) -> Floats:
    """Probability [m] that a beacon decodes on each edge of `near`, without bursts."""
    separation, poses, model = near.separation, robots.poses, medium.reception.of(config)
    if config.shadowing is not None and config.model != "perfect":
        separation = _effective(medium, config, config.shadowing, poses, near)
    if hasattr(model, "pair_probability"):
        edges = near.edges
        time = robots.tick * medium.dt
        probability: Floats = model.pair_probability(time, edges.peers, edges.robots, separation.take(near.pair))
    else:
        probability = model.probability(separation.take(near.pair))
    if config.jammers:
        probability = probability * _jamming_factor(config.jammers, poses).take(near.edges.rows)
    if config.partition:
        probability = probability * _same_side(config.partition, near.edges)
    return probability


def among(edges: Edges, present: Bools) -> Bools:
    """True for an edge between two robots that are `present` [n] [m]."""
    return present[edges.rows] & present[_senders(edges)]


def reopen(radio: Radio, back: Bools) -> Radio:
    """The radio when the robots of `back` [n] return: their contacts begin as if they had just come in range."""
    fresh = ~among(radio.edges, ~back)
    return _converted(radio, radio.edges, lambda values, first: np.where(fresh, values.dtype.type(first), values))


def _effective(
    medium: Medium, config: RadioConfig, shadows: ShadowingConfig, poses: Floats, near: Proximity
) -> Floats:
    """The separation [p] [m] at which the candidates in range would have their SNR without shadowing.

    A gain of g dB has the effect of a separation times 10^(-g/(10 nu)); in (3) this is exact.
    """
    in_range = np.flatnonzero(near.mask)
    separation = near.separation.copy()
    true_separation = separation.take(in_range)
    gain = shadowing.gain(
        medium.waves,
        shadows,
        poses,
        near.candidates.a.take(in_range),
        near.candidates.b.take(in_range),
        true_separation,
    )
    power = np.clip(gain / (-10.0 * config.path_loss_exponent), -_FARTHEST, _FARTHEST)
    separation[in_range] = true_separation * elementary.real_power(np.full_like(power, 10.0), power)
    return separation


def _jamming_factor(jammers: list[JammerConfig], poses: Floats) -> Floats:
    """Factor of the jammers on the reception probability of each robot [n]."""
    factor = np.ones(len(poses))
    for jammer in jammers:
        distance = geometry.separation(poses[:, geometry.X] - jammer.x, poses[:, geometry.Y] - jammer.y)
        factor[distance <= jammer.radius] *= jammer.reception_factor
    return factor


def _same_side(partition: list[list[int]], edges: Edges) -> Bools:
    """True for an edge between two robots of the same group [m]."""
    side = np.zeros(len(edges.ids), dtype=np.int64)
    for number, group in enumerate(partition, 1):
        side[np.searchsorted(edges.ids, group)] = number
    same: Bools = side[edges.rows] == side[_senders(edges)]
    return same


def _senders(edges: Edges) -> Ints:
    """Row of each edge's sender [m]."""
    return np.searchsorted(edges.ids, edges.peers)


def _converted(radio: Radio, edges: Edges, convert: Callable[[Array, float], Array]) -> Radio:
    """The radio over `edges`, each array converted by `convert(values, value of a pair that just came in range)`."""
    return Radio(
        edges,
        age=convert(radio.age, 0),
        reception=convert(radio.reception, CLOSED),
        sent=convert(radio.sent, 0),
        decoded=convert(radio.decoded, 0),
        probability=convert(radio.probability, math.nan),
        outage_sum=convert(radio.outage_sum, 0.0),
        gap=convert(radio.gap, 0),
        longest_gap=convert(radio.longest_gap, 0),
        burst=convert(radio.burst, bursts.UNKNOWN),
    )
