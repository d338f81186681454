"""The cases: all built-in scenarios, and variants that bring what these have late or not at all into seconds."""

import re
from typing import Any, NamedTuple

from world.config import builtin, scenario
from world.config.scenario import Scenario

SECONDS = 10.0
"""Default length of a case [s of simulated time]."""

Overrides = dict[str, Any]

HALVES = [[0, 1, 2, 3, 4], [5, 6, 7, 8, 9]]
FAULTS: list[Overrides] = [
    {"at": 0.2, "transmitter": {"robot": 4, "delay": 0.3, "loss": 0.2}},
    {"at": 0.2, "transmitter": {"robot": 2, "delay": 0.2}},
    {"at": 0.3, "clock": {"robot": 4, "skew": 0.05}},
    {"at": 0.4, "hang": [4, 6]},
    {"at": 0.5, "transmitter": {"robot": 5, "corrupt": True}},
    {"at": 0.6, "set": {"channel.partition": HALVES}},
    {"at": 0.8, "kill": [0]},
    {"at": 1.0, "set": {"channel.partition": []}},
    {"at": 1.2, "wake": [4, 6]},
    {"at": 1.3, "transmitter": {"robot": 5}},
    {"at": 1.4, "restart": [0]},
    {"at": 1.5, "clock": {"robot": 4}},
]
"""Every fault of a robot, within the shortest case."""

ROUGH: Overrides = {
    "channel.shadowing": {"deviation": 4.0, "decorrelation_distance": 15.0},
    "channel.bursts": {"bad_share": 0.1, "mean_length": 0.1, "loss": 0.9},
    "channel.jammers": [{"x": 100.0, "y": 0.0, "radius": 60.0, "reception_factor": 0.5}],
}
"""Every effect on top of a channel."""

NOISE: Overrides = {
    "sensing.pose_noise": 1.0,
    "sensing.heading_noise": 0.087,
    "sensing.pose_drift": 0.5,
    "sensing.pose_rate": 9.0,
    "sensing.pose_latency": 0.1,
    "robots.actuator_lag": 0.2,
    "robots.slip": 0.05,
}
"""Every error of sensors and bodies."""

SAMPLED: Overrides = {"seeking.index": "sampled", "seeking.index_transform": "none"}
SHAPED: Overrides = {"channel.path_loss_exponent": 2.7, "objective.shape_exponent": 3.3}
"""Exponents that are not whole: no product replaces the power."""

TABLE: Overrides = {"channel.model": "table", "channel.rows": [[10, 1.0], [90, 0.53], [170, 0.01]]}
METRICS = [
    {"use": "covered_area"},
    {"use": "delivery"},
    {"use": "link_index", "window": 1.0, "tolerance": 0.02},
    {"use": "links_connected"},
    {"use": "travel"},
]
SCHEMES = (
    "printed",
    "corrected, two nearest",
    "corrected",
    "measured",
    "gradient",
    "alpha_lattice",
    "voronoi",
    "fixed_separation",
    "krstic_wang",
    "connectivity",
)
"""The schemes of challenge.toml."""


class Case(NamedTuple):
    """A scenario with overrides by dotted path."""

    scenario: str
    overrides: Overrides


_VARIANTS = {
    "oracle-faults": Case("neighborhood", {"event": FAULTS, "metric": METRICS}),
    "oracle-shaped": Case("neighborhood", SHAPED),
    "oracle-logistic": Case("neighborhood", {"channel.model": "logistic"}),
    "oracle-jitter": Case("hundred", {"robots.count": 12, "robots.jitter": 5.0, "formation.rule": "disk"}),
    "sampled": Case("neighborhood", SAMPLED),
    "sampled-shadowing": Case("neighborhood", {**SAMPLED, **ROUGH}),
    "measured-faults": Case("measured", {"event": FAULTS, "metric": METRICS}),
    "measured-jump": Case("measured", {"event": [{"at": 1.0, "set": {"channel.reference_snr": 5e6}}]}),
    "measured-noise": Case("measured", {"event": FAULTS, **NOISE}),
    "oracle-slow-fixes": Case("neighborhood", {"sensing.pose_rate": 9.0, "sensing.pose_latency": 0.04}),
    "measured-alone": Case("measured", {"seeking.pooling": "none", **SHAPED}),
    "measured-shadowing": Case("measured", ROUGH),
    "measured-logistic": Case("measured", {"channel.model": "logistic", **ROUGH}),
    "measured-table": Case("measured", TABLE),
    **{f"challenge-{'-'.join(re.findall('[a-z_]+', name))}": Case("challenge", {"scheme": name}) for name in SCHEMES},
}
VARIANTS = {f"variants/{name}": case for name, case in _VARIANTS.items()}
"""Cases beside the built-in scenarios, by name."""

EMULATED = (
    "paper",
    "measured",
    "hundred",
    "paper-as-printed",
    *(name for name in VARIANTS if "challenge" not in name),
    "variants/challenge-gradient",
    "variants/challenge-connectivity",
)
"""All kinds of law, channel and fault, for the short form and for a processor that is emulated and so slow."""


def names() -> list[str]:
    """All cases."""
    return [*builtin.names(), *VARIANTS]


def load(name: str, seconds: float | None) -> Scenario:
    """A case by its name, cut to `seconds` of simulated time; with None its whole length."""
    case = VARIANTS.get(name, Case(name, {}))
    duration = {} if seconds is None else {"run.duration": seconds}
    return scenario.load(builtin.file_of(case.scenario), case.overrides | duration)
