"""Remarks on parts of a scenario that do not run as written: one line per kind.

None of them is an error. A run has a whole number of ticks, and events act at ticks, so some values are rounded. No
part of a scenario is changed or ignored without a remark.
"""

from collections.abc import Iterable, Iterator

import numpy as np

from fes.arrays import geometry
from fes.model import counts
from fes.model.config import TOLERANT, ChannelConfig, FormationConfig
from fes.model.seeking import SampledConfig
from fes.model.table import chosen
from fes.shapes import rules
from world.config import starts
from world.config.faults import TransmitterConfig
from world.config.scenario import Scenario, knows_channel

TOLERANCE = 1e-6
"""Largest distance from a multiple of a tick, as a share of the tick [1], that is ignored: decimals are rounded."""

MOST = 5
"""Largest number of times listed per line."""

FOLLOWED = 0.6
"""Share of their largest speed [1] at which robots still follow the dither of a configuration: the rest is for turns
and for errors of the formation."""

MOST_COMPARED = 1000
"""Largest team whose starts are compared in pairs."""

_OF_PLANS = ("plan_period", "marks_per_beacon", "orientations", "keep_range")
_OF_SEPARATION = ("separation_gain", "give_way_gain")
_OF_TOLERANCE = ("link_tolerance",)

UNNOTICED = (
    "the robots of this run are given the channel (seeking.index = 'oracle') and do not notice the change; "
    "those of the scenario measured-jump measure it"
)


def of(scenario: Scenario) -> list[str]:
    """All remarks on a scenario."""
    return [
        *_duration(scenario),
        *_late_events(scenario),
        *_rounded_events(scenario),
        *_delays(scenario),
        *_unnoticed(scenario),
        *_unused(scenario),
        *_outrun(scenario),
        *_ties(scenario),
        *_unweighted(scenario),
        *_without_plan(scenario),
        *_near_starts(scenario),
    ]


def is_unnoticed(scenario: Scenario, true: ChannelConfig) -> bool:
    """True if the robots were told the channel with which the scenario begins, and the `true` one differs from it."""
    return knows_channel(scenario) and scenario.channel.formula != true


def _duration(scenario: Scenario) -> Iterator[str]:
    duration, dt = scenario.run.duration, scenario.run.dt
    if _is_rounded(duration, dt) or duration < dt / 2.0:
        yield (
            f"run.duration {duration:g} s is not a multiple of run.dt {dt:g} s: "
            f"{scenario.ticks} ticks are run, {scenario.ticks * dt:.9g} s"
        )


def _late_events(scenario: Scenario) -> Iterator[str]:
    dt = scenario.run.dt
    late = [event.at for event in scenario.event if counts.ticks(event.at, dt) >= scenario.ticks]
    if late:
        end = scenario.ticks * dt
        yield f"event at {_listed(late)} s is not before the end of the run at {end:.9g} s: it never acts"


def _rounded_events(scenario: Scenario) -> Iterator[str]:
    dt = scenario.run.dt
    rounded = [event.at for event in scenario.event if _is_rounded(event.at, dt)]
    if rounded:
        ticks = _listed(counts.ticks(time, dt) * dt for time in rounded)
        yield f"event at {_listed(rounded)} s is not a multiple of run.dt {dt:g} s: it acts at {ticks} s"


def _delays(scenario: Scenario) -> Iterator[str]:
    dt = scenario.run.dt
    parts = [part for event in scenario.event for part in event.parts]
    delays = [part.delay for part in parts if isinstance(part, TransmitterConfig) and _is_rounded(part.delay, dt)]
    if delays:
        ticks = _listed(counts.ticks(delay, dt) * dt for delay in delays)
        yield (
            f"transmitter: delay {_listed(delays)} s is not a multiple of run.dt {dt:g} s: it is rounded to {ticks} s"
        )


def _unnoticed(scenario: Scenario) -> Iterator[str]:
    dt, ticks = scenario.run.dt, []
    for tick, channel in zip(scenario.changes, scenario.channels[1:], strict=True):
        if tick < scenario.ticks and is_unnoticed(scenario, channel.formula):
            ticks.append(tick * dt)
    if ticks:
        yield f"the channel is set at {_listed(ticks)} s, but {UNNOTICED}"


def _unused(scenario: Scenario) -> Iterator[str]:
    models = [chosen(channel.model).use for channel in scenario.channels]
    for model, key, is_given in (
        ("table", "rows", bool(scenario.channel.rows)),
        ("trace", "trace", scenario.channel.trace is not None),
    ):
        if is_given and model not in models:
            yield f"channel.{key} has no effect: channel.model is '{models[0]}', not '{model}'"
    formation = scenario.formation
    for keys, is_used, reason in (
        (_OF_PLANS, formation.configuration != "none", "formation.configuration is 'none'"),
        (_OF_SEPARATION, formation.safe_separation is not None, "formation.safe_separation is not set"),
        (_OF_TOLERANCE, chosen(formation.rule).use == TOLERANT, f"formation.rule is not '{TOLERANT}'"),
    ):
        given = [key for key in keys if getattr(formation, key) != FormationConfig.model_fields[key].default]
        if given and not is_used:
            yield f"formation.{', formation.'.join(given)} {'has' if len(given) == 1 else 'have'} no effect: {reason}"


def _outrun(scenario: Scenario) -> Iterator[str]:
    formation, limit = scenario.formation, scenario.formation.linear_limit
    if limit is None:
        return
    speed = rules.outermost_speed(formation, scenario.seeking, scenario.objective.losses, scenario.robots.number)
    if speed > FOLLOWED * limit:
        yield (
            f"the dither moves the outermost of {scenario.robots.number} robots at up to {speed:.3g} m/s: above "
            f"{FOLLOWED:g} x formation.linear_limit, {FOLLOWED * limit:.3g} m/s, robots fall behind it"
        )


def _ties(scenario: Scenario) -> Iterator[str]:
    formation = scenario.formation
    if formation.configuration == "lattice" and formation.rule == "relative_neighborhood":
        yield (
            f"formation.rule '{formation.rule}' drops about half of the equal links of a lattice: "
            f"'{TOLERANT}' keeps them"
        )


def _unweighted(scenario: Scenario) -> Iterator[str]:
    if scenario.formation.configuration != "none" and isinstance(scenario.seeking, SampledConfig):
        yield (
            "seeking.index 'sampled' seeks r*, and not the link length that is best for formation.configuration: "
            "'oracle' and 'measured' do"
        )


def _without_plan(scenario: Scenario) -> Iterator[str]:
    formation, end = scenario.formation, scenario.ticks * scenario.run.dt
    if formation.configuration != "none" and formation.plan_period >= end:
        yield (
            f"formation.plan_period {formation.plan_period:g} s: the first plan would come after the end of the run "
            f"at {end:.9g} s, and the robots stay where they are"
        )


def _near_starts(scenario: Scenario) -> Iterator[str]:
    safe = scenario.formation.safe_separation
    if safe is None or not 2 <= scenario.robots.number <= MOST_COMPARED:
        return
    distance = geometry.distances(starts.poses(scenario.robots, scenario.run.seed)[:, :2])
    distance[np.diag_indices(len(distance))] = np.inf
    if distance.min() < safe:
        first, second = divmod(int(distance.argmin()), len(distance))
        yield (
            f"robots {first} and {second} start {distance.min():.3g} m apart: formation.safe_separation, {safe:g} m, "
            "holds only for robots that start further apart"
        )


def _is_rounded(time: float, dt: float) -> bool:
    """True if a time [s] is not a whole number of ticks."""
    return abs(counts.ratio(time, dt) - counts.ticks(time, dt)) > TOLERANCE


def _listed(times: Iterable[float]) -> str:
    """A list of times, shortened to the first few.

    >>> _listed([0.5]), _listed(range(7))
    ('0.5', '0, 1, 2, 3, 4 and 2 more')
    """
    shown = [f"{time:.9g}" for time in times]
    more = f" and {len(shown) - MOST} more" if len(shown) > MOST else ""
    return ", ".join(shown[:MOST]) + more
