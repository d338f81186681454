"""The report to observers: the truth at one tick, and the robots' telemetry."""

from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from fes.arithmetic import elementary
from fes.arrays import masks
from fes.arrays.edges import Edges
from fes.arrays.types import Bytes, Floats, Ints
from fes.model import outage
from fes.model.config import FORMULAS
from fes.model.seeking import REFERENCE_SEPARATION, MeasuredConfig
from fes.protocol.report import Report
from world.config.radio import RadioConfig
from world.config.scenario import Scenario
from world.metrics import link_errors
from world.metrics.collector import MetricsCollector
from world.simulation import bursts, reception
from world.simulation.truth import State

STEP = 1e-3
"""Step in ln r of the slope of a channel without a formula [1]."""

PERIOD = 0.1
"""Wall-clock time between two reports [s]."""

_MOST_LINES = 64


class _Places(NamedTuple):
    """The links of a report [u], and where their numbers are."""

    low: Ints
    """The robot with the lower id."""
    high: Ints
    ab: Ints
    """Position of the link from `low` to `high` among the directed links, or -1."""
    ba: Ints
    """The same, from `high` to `low`."""
    forward: Ints
    """Position of the contact from `low` to `high`, or -1."""
    backward: Ints
    """The same, from `high` to `low`."""


# Links, contacts and channels stay the same objects from report to report while they do not change.
_known_places: WeakKeyDictionary[Edges, tuple[Edges, _Places]] = WeakKeyDictionary()
"""Links -> the contacts, and the places for both."""
_known_lines: dict[tuple[int, float], tuple[RadioConfig, tuple[float, float]]] = {}
"""Identity of a channel, and a scale -> the channel, and its line."""


@np.errstate(over="ignore", invalid="ignore")  # a run may diverge: the report shows that
def build(metrics: MetricsCollector, name: str, alive: Bytes, elapsed: float, ticks_per_s: float) -> Report:
    """The report of the last tick of `metrics`; `elapsed` [s] and `ticks_per_s` [1/s] are wall-clock.

    A robot counts as alive if its agent is `alive` [n] and it takes part; a robot waiting to rejoin takes no part.
    """
    scenario, state, telemetry = metrics.scenario, metrics.state, metrics.telemetry
    radio = state.radio
    low, high, ab, ba, forward, backward = _places(telemetry.links, radio.edges)
    separation = link_errors.link_separations(telemetry.links, state.poses)
    scale = getattr(scenario.seeking, "reference_separation", REFERENCE_SEPARATION)
    learnt = [_mean(_pick(row, ab), _pick(row, ba)) for row in telemetry.learnt]  # other laws learn other numbers
    none = np.zeros(0, dtype=np.int64)
    missed, late = (metrics.deadlines.missed, metrics.deadlines.late) if metrics.deadlines else (none, none)
    level = exponent = learnt_reception = np.full(len(low), np.nan)
    if isinstance(scenario.seeking, MeasuredConfig) and telemetry.learnt.size:
        level, exponent = learnt
        learnt_reception = elementary.exp(-elementary.exp(level + exponent * elementary.log(separation / scale)))
    true_level, true_exponent = _known_line(scenario, state.channel, scale)
    return Report(
        **metrics.shared(),
        scenario=name,
        tick=state.tick,
        ticks=scenario.ticks,
        dt=scenario.run.dt,
        elapsed=elapsed,
        ticks_per_s=ticks_per_s,
        alive=alive & state.present.astype(np.uint8),
        poses=state.poses,
        a=low,
        b=high,
        separation=separation,
        estimate_ab=_pick(telemetry.estimates, ab),
        estimate_ba=_pick(telemetry.estimates, ba),
        outage=_outage(scenario, state, separation, forward, backward),
        sent=_both_ways(radio.sent, forward, backward),
        decoded=_both_ways(radio.decoded, forward, backward),
        longest_gap=_both_ways(radio.longest_gap, forward, backward, np.maximum),
        learnt_reception=learnt_reception,
        learnt_level=level,
        learnt_exponent=exponent,
        true_level=true_level,
        true_exponent=true_exponent,
        mean_estimate_error=metrics.tracking.error,
        changed_at=metrics.tracking.now.since * scenario.run.dt,
        tracking_time=metrics.tracking.time_to_near,
        separation_error_max=metrics.link_errors.errors["separation_error"],
        missed=missed.copy(),
        late=late.copy(),
        disk_connected=metrics.link_errors.disk_now,
        **(metrics.team.report(state, telemetry) if metrics.team is not None else {}),
    )


def link_outage(metrics: MetricsCollector) -> Floats:
    """True outage of each of `telemetry.links.undirected` at the last tick [u], as in the report; NaN if unknown."""
    scenario, state, links = metrics.scenario, metrics.state, metrics.telemetry.links
    _, _, _, _, forward, backward = _places(links, state.radio.edges)
    return _outage(scenario, state, link_errors.link_separations(links, state.poses), forward, backward)


def _places(links: Edges, contacts: Edges) -> _Places:
    """The places of links and of their contacts."""
    known = _known_places.get(links)
    if known is None or known[0] is not contacts:
        a, b = link_errors.ends(links)
        low, high = np.minimum(a, b), np.maximum(a, b)
        ahead, back = links.key(low, high), links.key(high, low)
        positions = links.find(ahead), links.find(back), contacts.find(ahead), contacts.find(back)
        known = _known_places[links] = contacts, _Places(low, high, *positions)
    return known[1]


def _pick(values: Floats, positions: Ints) -> Floats:
    """The value at each position; NaN at position -1."""
    return np.where(positions >= 0, values[positions], np.nan) if len(values) else np.full(len(positions), np.nan)


def _mean(a: Floats, b: Floats) -> Floats:
    """Mean of two values; where one of them is NaN, the other value."""
    return np.where(np.isnan(a), b, np.where(np.isnan(b), a, 0.5 * (a + b)))


def _both_ways(counts: Ints, forward: Ints, backward: Ints, join: np.ufunc = np.add) -> Floats:
    """A count of each contact, both directions joined; a direction without a contact counts 0."""
    if not len(counts):
        return np.zeros(len(forward))
    ahead, back = (np.where(positions >= 0, counts[positions], 0) for positions in (forward, backward))
    result: Floats = join(ahead, back).astype(np.float64)
    return result


def _outage(scenario: Scenario, state: State, separation: Floats, forward: Ints, backward: Ints) -> Floats:
    """True outage of each link, both directions averaged: of the last beacon, or of the channel without a beacon."""
    known = np.full(len(separation), np.nan)
    if len(state.radio.edges):
        decoded = 0.5 * (state.radio.probability[forward] + state.radio.probability[backward])
        known = np.where((forward >= 0) & np.isfinite(decoded), 1.0 - decoded, np.nan)
    is_known = np.isfinite(known)
    if masks.is_full(is_known):
        return known
    formula = _without_beacon(scenario, state.channel, separation)
    lost = 1.0 - (1.0 - formula) * bursts.mean_reception_factor(state.channel.bursts)
    return np.where(is_known, known, lost)


def _without_beacon(scenario: Scenario, channel: RadioConfig, separation: Floats) -> Floats:
    """Outage by separation alone [l]; NaN for a channel that does not depend on it."""
    if channel.model in FORMULAS:
        return outage.outage_probability(separation, channel)
    model = reception.model(channel, reception.context(scenario))
    if not hasattr(model, "probability"):
        return np.full(len(separation), np.nan)
    lost: Floats = 1.0 - model.probability(separation)
    return lost


def _known_line(scenario: Scenario, channel: RadioConfig, scale: float) -> tuple[float, float]:
    """The reception line; computed once for a channel with a formula, which has no other parameters."""
    if channel.model not in FORMULAS:
        return _reception_line(scenario, channel, scale)
    key = id(channel), scale
    known = _known_lines.get(key)
    if known is None or known[0] is not channel:
        if len(_known_lines) >= _MOST_LINES:
            _known_lines.clear()
        known = _known_lines[key] = channel, _reception_line(scenario, channel, scale)
    return known[1]


@np.errstate(divide="ignore")  # a channel without loss has no line
def _reception_line(scenario: Scenario, channel: RadioConfig, scale: float) -> tuple[float, float]:
    """Level and exponent of an exact fit of the channel at `scale` [m]: ln(-ln p), and its slope in ln r."""
    if channel.model not in FORMULAS:
        near = scale * elementary.exp(np.array([-STEP, 0.0, STEP]))
        below, level, above = elementary.log(-elementary.log1p(-_without_beacon(scenario, channel, near))).tolist()
        return level, (above - below) / (2.0 * STEP)
    if channel.model != "logistic":
        rate = outage.exponent_scale(channel) * elementary.power(np.array(scale), channel.path_loss_exponent)
        return float(elementary.log(rate)), channel.path_loss_exponent
    separation = np.array([scale])
    rate = elementary.log_sum_exp(outage.logistic_excess(separation, channel))[0]  # -ln p
    return float(elementary.log(rate)), float(-scale * outage.log_reception_slope(separation, channel)[0] / rate)
