"""Remarks on parts of a scenario that do not run as written: one line per kind.

None of them is an error. A run has a whole number of ticks, and events act at ticks, so some values are rounded. No
part of a scenario is changed or ignored without a remark.
"""

from collections.abc import Iterable, Iterator

from fes.model import counts
from fes.model.config import TOLERANT, ChannelConfig
from fes.model.table import chosen
from fes.shapes import rules
from world.config.faults import TransmitterConfig
from world.config.scenario import Scenario, knows_channel

TOLERANCE = 1e-6
"""Largest distance from a multiple of a tick, as a share of the tick [1], that is ignored: decimals are rounded."""

MOST = 5
"""Largest number of times listed per line."""

FOLLOWED = 0.6
"""Share of their largest speed [1] at which robots still follow the dither of a configuration."""

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
