"""The report to observers: the truth at one tick, and what robots say of themselves."""

import numpy as np

from fes import outage
from fes.arrays import Bytes, Floats, Ints
from fes.edges import Edges
from fes.report import Report
from world import bursts, metrics
from world.channel import Radio
from world.metrics import Tally
from world.scenario import Scenario
from world.simulation import State

PERIOD = 0.1
"""Wall-clock time between two reports [s]."""


def build(
    scenario: Scenario,
    name: str,
    state: State,
    tally: Tally,
    links: Edges,
    estimates: Floats,
    alive: Bytes,
    elapsed: float,
    ticks_per_s: float,
) -> Report:
    """The report of one tick; `links` and `estimates` [l] are what the robots said at it."""
    a, b = metrics.ends(links)
    low, high = np.minimum(a, b), np.maximum(a, b)
    separation = metrics.separations(state.poses, low, high)
    return Report(
        scenario=name,
        tick=state.tick,
        ticks=scenario.ticks,
        dt=scenario.run.dt,
        optimal_separation=tally.optimal,
        elapsed=elapsed,
        ticks_per_s=ticks_per_s,
        alive=alive,
        poses=state.poses,
        a=low,
        b=high,
        separation=separation,
        estimate_ab=_estimate(links, estimates, low, high),
        estimate_ba=_estimate(links, estimates, high, low),
        outage=_outage(state, separation, low, high),
        decoded_ratio=_decoded_ratio(state.radio, low, high),
        beacons_sent=state.sent,
        beacons_decoded=state.decoded,
        disagreement=tally.errors["disagreement"],
        estimate_error_max=tally.errors["estimate_error"],
        separation_error_max=tally.errors["separation_error"],
        disk_connected=tally.disk_now,
    )


def _estimate(links: Edges, estimates: Floats, robot: Ints, peer: Ints) -> Floats:
    """The estimate of each robot for its link to `peer`, or NaN."""
    if len(links) == 0:
        return np.zeros(0)
    at = links.find(links.key(robot, peer))
    return np.where(at >= 0, estimates[at], np.nan)


def _outage(state: State, separation: Floats, a: Ints, b: Ints) -> Floats:
    """True outage of each link, both ways averaged: of the last beacon, or after the formula where there was none."""
    formula = outage.outage_probability(separation, state.channel)
    lost, edges = 1.0 - (1.0 - formula) * bursts.kept_on_average(state.channel.bursts), state.radio.edges
    if len(edges) == 0:
        return lost
    here, there = edges.find(edges.key(a, b)), edges.find(edges.key(b, a))
    decoded = 0.5 * (state.radio.probability[here] + state.radio.probability[there])
    return np.where((here >= 0) & np.isfinite(decoded), 1.0 - decoded, lost)


def _decoded_ratio(radio: Radio, a: Ints, b: Ints) -> Floats:
    """Beacons decoded of those sent on each contact, both ways together; NaN before the first."""
    sent, decoded = np.zeros(len(a)), np.zeros(len(a))
    if len(radio.edges):
        for receiver, sender in ((a, b), (b, a)):
            at = radio.edges.find(radio.edges.key(receiver, sender))
            sent += np.where(at >= 0, radio.sent[at], 0)
            decoded += np.where(at >= 0, radio.decoded[at], 0)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(sent > 0, decoded / sent, np.nan)
