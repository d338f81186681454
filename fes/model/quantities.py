"""The quantities of a run: name, unit and meaning of every value in its summary.

The one table behind the keys of `summary.json`, the keys that an expectation may name, and the reference page.
"""

from collections.abc import Iterable
from typing import Any, NamedTuple

NUMBER, FLAG, TEXT = "a number", "true or false", "a text"
"""Kinds of a value."""

Shape = str | list["Shape"] | tuple["Shape", ...] | dict[str, "Shape"]
"""A scalar by its kind, a list of any length by its entry, a row by its columns, or a table by its keys."""


class Quantity(NamedTuple):
    """A value in the summary of a run."""

    name: str
    """Dotted path; `[]` stands for each entry of a list, a number for a column of a row: `tracking[].rmse`. `*`
    stands for any name."""
    unit: str
    """SI unit, 1 for a ratio, the noun for a count; empty for a text, a flag, a seed or the id of a robot."""
    description: str
    null: str = ""
    """Condition under which the value is null; any number that is not finite is null too."""
    kind: str = NUMBER
    is_optional: bool = False
    """True if only some summaries have the key."""


LEVELS = {
    "disagreement_1m": ("disagreement", 1.0),
    "estimate_1m": ("estimate_error", 1.0),
    "estimate_0_1m": ("estimate_error", 0.1),
    "separation_1m": ("separation_error", 1.0),
    "separation_0_1m": ("separation_error", 0.1),
}
"""Key of `time_to` -> an error over the links, and the level [m] that it must stay below."""

TEAM_LEVELS = {"team_index_95_at": 0.95, "team_index_99_at": 0.99}
"""Key of a summary -> a share of the team index's target, at which it must stay."""

_NO_INDEX = "there are fewer than two robots, or more than 100"
_NO_LINKS = "no robot has a link at the end"
_NO_TIME = "no wall-clock time passed"
_NOT_SETTLED = "the segment ended within 60 s"
_NOT_USED = "this robot does not use the link"
_LOCKSTEP = "the clock is not live"

SUMMARY = (
    Quantity("scenario", "", "Name of the scenario.", kind=TEXT),
    Quantity("seed", "", "Seed of every random draw of the run."),
    Quantity("backend", "", "`processes`: one process per agent. `inprocess`: one loop.", kind=TEXT),
    Quantity("clock", "", "Clock of the run: `lockstep` or `live`.", kind=TEXT),
    Quantity("robots", "robots", "Number of robots."),
    Quantity("ticks", "ticks", "Number of ticks that were run."),
    Quantity("dt", "s", "Tick length."),
    Quantity("simulated_s", "s", "Simulated time: ticks times tick length."),
    Quantity("wall_s", "s", "Wall-clock time of the run."),
    Quantity("ticks_per_s", "1/s", "Ticks per second of wall-clock time.", _NO_TIME),
    Quantity("real_time_factor", "1", "Simulated time over wall-clock time.", _NO_TIME),
    Quantity(
        "optimal_separation",
        "m",
        "r*, the separation that maximizes the index (16), at the last tick. Where a configuration is sought, it is "
        "r_beta, the best link length of its shape, and all errors are relative to that.",
    ),
    Quantity("edges[].0", "", "Lower robot id of a link in use at the last tick."),
    Quantity("edges[].1", "", "Higher robot id of the link."),
    Quantity(
        "edges[].2", "m", "Separation of its two robots; with a physical dither, its mean over a dither period."
    ),
    Quantity("edges[].3", "m", "Separation estimate of the robot with the lower id.", _NOT_USED),
    Quantity("edges[].4", "m", "Separation estimate of the robot with the higher id.", _NOT_USED),
    Quantity("separation_error_max", "m", "Largest |separation - r*| over the links at the end.", _NO_LINKS),
    Quantity("separation_error_rms", "m", "Root mean square of separation - r* over the links.", _NO_LINKS),
    Quantity("disagreement", "m", "Sum over the links of the difference of their two estimates.", _NO_LINKS),
    Quantity("estimate_error_max", "m", "Largest |estimate - r*| at the end.", _NO_LINKS),
    Quantity("estimate_error_rms", "m", "Root mean square of estimate - r*.", _NO_LINKS),
    Quantity(
        "disk_connected_always",
        "",
        "True if the graph of all robots in range was connected at each tick from the first contact on.",
        kind=FLAG,
    ),
    Quantity("links_connected_always", "", "The same for the graph of the links in use.", kind=FLAG),
    Quantity(
        "algebraic_connectivity",
        "1",
        "Second smallest eigenvalue of the Laplacian of the links at the end; 0 if a robot is dead.",
        "there are more than 1,500 robots",
    ),
    Quantity("beacons_sent", "beacons", "Beacons sent on open contacts."),
    Quantity("beacons_decoded", "beacons", "Beacons that their receivers decoded."),
    *(
        Quantity(
            f"time_to.{name}",
            "s",
            f"First time from which the {error.replace('_', ' ')} stays below {level:g} m for 10 s, or to the end.",
            "it never does",
        )
        for name, (error, level) in LEVELS.items()
    ),
    Quantity("digest", "", "SHA-256 over the poses and twists of all ticks.", kind=TEXT),
    Quantity("tracking[].at", "s", "Start of a segment: tick 0, or a change of the channel."),
    Quantity(
        "tracking[].optimal_separation",
        "m",
        "r* at the start of the segment; errors are relative to the current one.",
    ),
    Quantity(
        "tracking[].time_to_1m",
        "s",
        "Time from the start of the segment until the mean estimate stays within 1 m of r*: for 10 s in the first "
        "segment, 5 s in a later one.",
        "it never does",
    ),
    Quantity("tracking[].bias", "m", "Mean of the mean estimate's error, from 60 s on.", _NOT_SETTLED),
    Quantity("tracking[].rmse", "m", "Root mean square of the same error.", _NOT_SETTLED),
    Quantity("tracking[].separation_rmse", "m", "Root mean square of the links' separation errors.", _NOT_SETTLED),
    Quantity("tracking[].disagreement_max", "m", "Largest disagreement.", _NOT_SETTLED),
    Quantity("tracking[].index", "1", "Mean over links and ticks of the true index J.", _NOT_SETTLED),
    Quantity("radio[].0", "", "Receiver of a contact that is open at the end."),
    Quantity("radio[].1", "", "Sender of the contact."),
    Quantity("radio[].2", "beacons", "Beacons sent since the contact opened."),
    Quantity("radio[].3", "beacons", "Beacons decoded of these."),
    Quantity("radio[].4", "1", "Mean true outage probability of these."),
    Quantity("radio[].5", "beacons", "Most beacons lost in a row."),
    Quantity("deadlines.due[]", "ticks", "Per robot: deadlines of the live clock.", _LOCKSTEP),
    Quantity("deadlines.missed[]", "ticks", "Per robot: deadlines without the command of their tick.", _LOCKSTEP),
    Quantity("deadlines.stopped[]", "ticks", "Per robot: deadlines without a command of the last 0.25 s.", _LOCKSTEP),
    Quantity("deadlines.late[]", "commands", "Per robot: commands that arrived after their deadline.", _LOCKSTEP),
    Quantity("deadlines.missed_share", "1", "Missed deadlines over all deadlines.", f"{_LOCKSTEP}, or none was due"),
    Quantity("deadlines.slipped_s", "s", "Total delay of the world's own ticks.", _LOCKSTEP),
    Quantity("arithmetic.fingerprint", "", "Hash of the elementary functions, the same on every machine.", kind=TEXT),
    Quantity("arithmetic.numpy", "", "Version of numpy; it changes no digit.", kind=TEXT),
    Quantity("arithmetic.core", "", "Implementation that computed the run.", kind=TEXT),
    Quantity("links_gap_longest", "s", "Longest time in which the links did not connect all robots present."),
    Quantity(
        "unscheduled_absences",
        "robot-ticks",
        "Robot-ticks in which a robot took no part although the scenario had it present.",
    ),
    Quantity(
        "links_lost_at",
        "s",
        "Time from which no robot had a link.",
        "a robot has one at the end, or no contact could open yet",
    ),
    Quantity(
        "smallest_separation",
        "m",
        "Smallest separation of two robots that were present, over all ticks.",
        "fewer than two robots were present",
    ),
    Quantity(
        "model_free",
        "",
        "True if no process of the robots has loaded the channel's formula.",
        "world and robots share a process",
        kind=FLAG,
    ),
    Quantity(
        "team_index",
        "1",
        "Team index F: coverage of the whole team, and its delivery after the worst loss of one robot.",
        _NO_INDEX,
        is_optional=True,
    ),
    Quantity(
        "team_index_target",
        "1",
        "F of the shape that the team takes up, or of the patch of the lattice, at its r_beta.",
        f"{_NO_INDEX}, or the channel has no r*",
        is_optional=True,
    ),
    Quantity(
        "cutting_robots",
        "robots",
        "Robots whose loss would cut the links in use at the last tick.",
        "these links do not connect the robots present",
        is_optional=True,
    ),
    Quantity(
        "covered_area", "m^2", "Area within r_min of a robot that is present, at the last tick.", is_optional=True
    ),
    Quantity(
        "delivery_after_loss",
        "1",
        "Geometric mean over pairs of robots of the quality of their best route, after the worst loss.",
        _NO_INDEX,
        is_optional=True,
    ),
    *(
        Quantity(
            name,
            "s",
            f"Time from which the team index stays at {share:.0%} of its target or above, in steps of 0.1 s.",
            "it is below at the last step, or either is null",
            is_optional=True,
        )
        for name, share in TEAM_LEVELS.items()
    ),
    Quantity(
        "metrics.*.*",
        "that of the metric",
        "A number of a metric of the scenario, by the names of the metric and the number.",
        "the metric has no value for it, or one that is not finite",
    ),
    Quantity("expectations[].of", "", "Key of the summary to which the expectation applies.", kind=TEXT),
    Quantity("expectations[].expected", "", "The expectation, in words.", kind=TEXT),
    Quantity("expectations[].seen", "", "Value of the key.", "the summary has none", kind="any of these"),
    Quantity("expectations[].holds", "", "True if the value meets the expectation.", kind=FLAG),
)
"""Every value of a summary, in the order of `summary.json`."""

OPTIONAL = frozenset(quantity.name for quantity in SUMMARY if quantity.is_optional)
"""Keys of the team index: in a summary only where a configuration is sought, or the objective asks for it."""

VERDICTS = "expectations"
"""Key of the summary that no expectation can name."""


def shape(quantities: Iterable[Quantity] = SUMMARY) -> dict[str, Shape]:
    """Nested shape of a summary with these quantities.

    >>> shape([Quantity("edges[].0", "m", ""), Quantity("edges[].1", "m", ""), Quantity("time_to.x", "s", "")])
    {'edges': [('a number', 'a number')], 'time_to': {'x': 'a number'}}
    """
    root: dict[str, Any] = {}
    for quantity in quantities:
        *parents, leaf = quantity.name.replace("[]", ".[]").split(".")
        table = root
        for parent in parents:
            table = table.setdefault(parent, {})
        table[leaf] = quantity.kind
    return {key: _shape(value) for key, value in root.items()}


def _shape(node: Any) -> Shape:
    if not isinstance(node, dict):
        return str(node)
    parts = {key: _shape(value) for key, value in node.items()}
    if set(parts) == {"[]"}:
        return [parts["[]"]]
    return tuple(parts.values()) if all(key.isdecimal() for key in parts) else parts


def ordered(values: dict[str, Any]) -> dict[str, Any]:
    """The values of a summary in the order of the table; raises KeyError unless their keys are the table's.

    Optional ones are all there, or none of them.
    """
    keys = list(shape())
    if not values.keys() & OPTIONAL:
        keys = [key for key in keys if key not in OPTIONAL]
    if set(keys) != values.keys():
        raise KeyError(f"only in the summary, or only in its table: {sorted(set(keys) ^ values.keys())}")
    return {key: values[key] for key in keys}
