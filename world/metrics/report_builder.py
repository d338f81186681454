"""The report to observers: the truth at one tick, and what robots say of themselves."""

import math

import numpy as np

from fes.arrays.edges import Edges
from fes.arrays.types import Bytes, Floats, Ints
from fes.model import outage
from fes.protocol.report import Report
from world.config.radio import RadioConfig
from world.metrics import link_errors
from world.metrics.collector import MetricsCollector
from world.simulation import bursts
from world.simulation.truth import State

PERIOD = 0.1
"""Wall-clock time between two reports [s]."""


@np.errstate(over="ignore", invalid="ignore")  # a run may diverge: it is shown as it is
def build(metrics: MetricsCollector, name: str, alive: Bytes, elapsed: float, ticks_per_s: float) -> Report:
    """The report of the last tick of `metrics`; `elapsed` [s] and `ticks_per_s` [1/s] are wall-clock.

    A robot whose agent is `alive` [n] is shown as such if it takes part: who waits to come back does not yet.
    """
    scenario, state, said = metrics.scenario, metrics.state, metrics.telemetry
    a, b = link_errors.ends(said.links)
    low, high = np.minimum(a, b), np.maximum(a, b)
    separation = link_errors.separations(state.poses, low, high)
    ab, ba = _place(said.links, low, high), _place(said.links, high, low)
    radio = state.radio
    here, there = _place(radio.edges, low, high), _place(radio.edges, high, low)
    scale = scenario.seeking.reference_separation
    learnt = [_mean(_pick(row, ab), _pick(row, ba)) for row in said.learnt]
    none = np.zeros(0, dtype=np.int64)
    missed, late = (metrics.deadlines.missed, metrics.deadlines.late) if metrics.deadlines else (none, none)
    level, exponent = learnt if said.learnt.size else [np.full(len(low), np.nan)] * 2
    true_level, true_exponent = _reception_line(state.channel, scale)
    return Report(
        scenario=name,
        tick=state.tick,
        ticks=scenario.ticks,
        dt=scenario.run.dt,
        optimal_separation=metrics.optimal,
        elapsed=elapsed,
        ticks_per_s=ticks_per_s,
        alive=alive & state.present.astype(np.uint8),
        poses=state.poses,
        a=low,
        b=high,
        separation=separation,
        estimate_ab=_pick(said.estimates, ab),
        estimate_ba=_pick(said.estimates, ba),
        outage=_outage(state, separation, here, there),
        sent=_both_ways(radio.sent, here, there),
        decoded=_both_ways(radio.decoded, here, there),
        longest_gap=_both_ways(radio.longest_gap, here, there, np.maximum),
        learnt_reception=np.exp(-np.exp(level + exponent * np.log(separation / scale))),
        learnt_level=level,
        learnt_exponent=exponent,
        true_level=true_level,
        true_exponent=true_exponent,
        mean_estimate_error=metrics.tracking.error,
        changed_at=metrics.tracking.now.since * scenario.run.dt,
        tracking_time=metrics.tracking.time_to_near,
        beacons_sent=state.sent,
        beacons_decoded=state.decoded,
        disagreement=metrics.link_errors.errors["disagreement"],
        estimate_error_max=metrics.link_errors.errors["estimate_error"],
        separation_error_max=metrics.link_errors.errors["separation_error"],
        missed=missed.copy(),
        late=late.copy(),
        disk_connected=metrics.link_errors.disk_now,
    )


def _place(links: Edges, robot: Ints, peer: Ints) -> Ints:
    """Where each robot's link to `peer` stands, or -1."""
    return links.find(links.key(robot, peer))


def _pick(values: Floats, at: Ints) -> Floats:
    """The value at each place; NaN where it is -1."""
    return np.where(at >= 0, values[at], np.nan) if len(values) else np.full(len(at), np.nan)


def _mean(a: Floats, b: Floats) -> Floats:
    """The mean of two, or the one that is a number."""
    return np.where(np.isnan(a), b, np.where(np.isnan(b), a, 0.5 * (a + b)))


def _both_ways(of: Ints, here: Ints, there: Ints, add: np.ufunc = np.add) -> Floats:
    """A number of each contact since it opened, both ways taken together; 0 where there is no contact."""
    if not len(of):
        return np.zeros(len(here))
    result: Floats = add(np.where(here >= 0, of[here], 0), np.where(there >= 0, of[there], 0)).astype(np.float64)
    return result


def _outage(state: State, separation: Floats, here: Ints, there: Ints) -> Floats:
    """True outage of each link, both ways averaged: of the last beacon, or after the formula where there was none."""
    formula = outage.outage_probability(separation, state.channel)
    lost = 1.0 - (1.0 - formula) * bursts.mean_reception_factor(state.channel.bursts)
    if not len(state.radio.edges):
        return lost
    decoded = 0.5 * (state.radio.probability[here] + state.radio.probability[there])
    return np.where((here >= 0) & np.isfinite(decoded), 1.0 - decoded, lost)


def _reception_line(channel: RadioConfig, scale: float) -> tuple[float, float]:
    """Level and exponent that an exact fit of the formula has at `scale` [m]: ln(-ln p), and its slope in ln r."""
    if channel.model != "logistic":
        try:
            rate = outage.exponent_scale(channel) * scale**channel.path_loss_exponent
        except OverflowError:
            rate = math.inf
        return math.log(rate) if rate > 0.0 else -math.inf, channel.path_loss_exponent
    at = np.array([scale])
    rate = float(np.logaddexp(0.0, outage.logistic_excess(at, channel))[0])  # -ln p
    return math.log(rate), float(-scale * outage.log_reception_slope(at, channel)[0] / rate)
