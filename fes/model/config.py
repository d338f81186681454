"""Configuration of an agent: all that it may know of a run. It arrives in the Welcome, never from a file.

The world's scenario consists of the same tables. Every model is frozen, complete and rejects unknown fields. Symbols
in parentheses are the paper's. The docstring of a field is its description in `fes schema`, and names its unit in
brackets.
"""

from collections.abc import Collection
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from fes.model.seeking import SeekingConfig
from fes.model.table import Choice, Exponent, NonNegative, OwnTable, Positive, Use, chosen

Clock = Annotated[
    Literal["lockstep", "live"],
    Field(
        description="`lockstep`: each tick waits for the commands of all robots. `live`: ticks follow the wall "
        "clock and wait for no robot."
    ),
]

MAX_DELAY = 10_000
"""Longest delay of a transmitter [ticks]; it bounds the transmitter's memory."""

MAX_SKEW = 10.0
"""Largest skew of a clock [s]."""


MARKS_AND_PLANS, TOLERANT = "marks_and_plans", "tolerant_relative_neighborhood"
"""The formation law that takes up a configuration, and the neighbor rule that keeps the links of a lattice: their
parameters are the table [formation]."""

Configuration = Literal["none", "lattice", "line", "ring", "ladder", "offsets"]
Coordinate = Annotated[float, Field(ge=-1e3, le=1e3)]

FORMULAS = ("rayleigh", "logistic", "perfect")
"""Reception models that have a formula."""


class ChannelConfig(OwnTable):
    """The formula of the radio channel: the truth of the world. An agent gets it for the oracle index only."""

    model: Choice = "rayleigh"
    """Reception model. `rayleigh`: beacons decode with the probability of (3). `logistic`: with
    1 / (1 + exp((r - midpoint) / width)), a shape that no exponent gives (3). `perfect`: every beacon in range
    decodes. `table`: as in `rows`. `trace`: as in the file `trace`. An extension is named by `module:Class`, by the
    name of an installed one, or as a table with `use` and its parameters."""
    reference_snr: Positive = 1e7
    """Signal-to-noise ratio (SNR) at the reference distance [1] (P0/sigma^2)."""
    spectral_efficiency: Annotated[float, Field(gt=0, le=100, allow_inf_nan=False)] = 2.0
    """Spectral efficiency below which the link is in outage [bit/s/Hz] (delta)."""
    path_loss_exponent: Exponent = 3.0
    """Path-loss exponent [1] (nu of (3))."""
    reference_distance: Annotated[float, Field(ge=1e-6, le=1e6)] = 1.0
    """Distance of the reference SNR [m] (r0)."""
    logistic_midpoint: Positive = 100.0
    """Separation at which the logistic channel decodes half of the beacons [m]."""
    logistic_width: Annotated[float, Field(ge=1e-3, le=1e6)] = 12.0
    """Width of the logistic channel's transition [m]; at the midpoint, reception falls by 1/(4 width) per meter."""
    communication_range: Positive = 150.0
    """Hard cut-off of the radio [m] (r_x)."""


class ObjectiveConfig(OwnTable):
    """The separations that the team prefers, by equation (16)."""

    minimum_separation: Positive = 50.0
    """Smallest separation that the team prefers [m] (r_min)."""
    maximum_separation: Positive = 150.0
    """Separation with the largest tolerable outage [m] (r_x)."""
    shape_exponent: Exponent = 4.0
    """Shape exponent of the index [1] (nu of (16); Fig. 3 has 4)."""
    coverage_weight: Positive = 1.0
    """Weight of coverage against delivery in the team index [1] (lambda)."""
    losses: Literal[0, 1] = 1
    """Number of robots whose loss the team index takes into account."""
    team_index: bool = False
    """True if the team index is computed also where no configuration is sought."""

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.minimum_separation >= self.maximum_separation:
            raise ValueError(
                f"minimum_separation must be below maximum_separation, "
                f"got {self.minimum_separation:g} and {self.maximum_separation:g}"
            )
        return self


class FormationConfig(OwnTable):
    """The formation law, its graph, and the motion that follows its pull by (6), (7)."""

    law: Choice = "paper"
    """Formation law, which computes where each robot is pulled. `paper`: toward the desired separations of its links,
    with the weights (9). An extension is named by `module:Class`, by the name of an installed one, or as a table
    with `use` and its parameters."""
    rule: Choice = "relative_neighborhood"
    """Neighbor rule, which selects the links among the robots in range. `disk`: all of them. `two_nearest`: the two
    nearest. `relative_neighborhood`: those without a third robot nearer to both ends.
    `tolerant_relative_neighborhood`: those without a third robot that is nearer to both ends by `link_tolerance`: so
    the equal links of a lattice are kept. An extension is named as for `law`."""
    link_tolerance: Annotated[float, Field(ge=0, lt=1)] = 0.1
    """Share by which a third robot must be nearer to both ends to exclude a link [1], for the rule
    `tolerant_relative_neighborhood`."""
    configuration: Configuration = "none"
    """Final configuration that the whole team takes up, by marks and plans. `none`: the law above decides alone.
    `lattice`: the best patch of the triangular lattice. `line`, `ring`, `ladder`: these shapes. `offsets`: the
    places in the field `offsets`. Each of these shapes replaces the law."""
    offsets: list[Annotated[tuple[Coordinate, Coordinate], Field(strict=False)]] = Field(default=[], max_length=200)
    """Places of the configuration `offsets` as multiples of the link length [1]. A team of n robots takes the first n
    of them. For each n, the nearest two of these must be 1 apart, and links of up to 1.1 must connect them."""
    plan_period: Positive = 2.0
    """Period of the plans of a configuration [s]; each robot marks once in a period where it will be."""
    marks_per_beacon: Annotated[int, Field(ge=1, le=16)] = 8
    """Marks of other robots that a beacon relays."""
    orientations: Annotated[int, Field(ge=1, le=360)] = 6
    """Orientations of the shape that a plan compares."""
    keep_range: Positive = 140.0
    """Separation up to which a plan counts on a link [m]: below the radio's range by a margin for turns."""
    linear_gain: Positive = 1.0
    """Gain of the linear velocity [1/s] (mu)."""
    angular_gain: Positive = 10.0
    """Gain of the angular velocity [rad/s/m] (mu'); the paper requires mu' >= mu."""
    linear_limit: Positive | None = None
    """Largest linear speed [m/s]; none by default, as in the paper."""
    angular_limit: Positive | None = None
    """Largest angular speed [rad/s]; none by default, as in the paper."""
    contact_timeout: Annotated[float, Field(gt=0, le=1e6)] = 1.0
    """Time without a beacon after which a peer is no longer a contact [s]."""
    safe_separation: Positive | None = None
    """Separation below which two robots never come, if they start further apart [m]; none by default. It needs
    `linear_limit`."""
    separation_gain: Positive = 1.0
    """Rate at which the separation of two robots may approach the safe one [1/s]."""
    give_way_gain: NonNegative = 1.0
    """Gain with which robots pass each other on the right, where the safe separation bounds their motion [1]."""

    @property
    def acting_law(self) -> str | Use:
        """The formation law that acts: `law`, or the one that takes up a configuration."""
        return self.law if self.configuration == "none" else MARKS_AND_PLANS

    @model_validator(mode="after")
    def _one_law(self) -> Self:
        for name, choice in (("law", chosen(self.law)), ("rule", chosen(self.rule))):
            if choice.use == MARKS_AND_PLANS:
                raise ValueError(
                    f"{name}: '{MARKS_AND_PLANS}' cannot be named, set formation.configuration to a shape"
                )
            if choice.use == TOLERANT and choice.parameters:
                given = next(iter(choice.parameters))
                raise ValueError(
                    f"{name}: '{TOLERANT}' has its settings in [formation] and takes no parameter, got '{given}'"
                )
        if self.configuration != "none" and self.law != "paper":
            law = chosen(self.law).use
            raise ValueError(f"law: configuration '{self.configuration}' replaces it and needs 'paper', got '{law}'")
        if self.offsets and self.configuration != "offsets":
            raise ValueError(f"offsets: only configuration 'offsets' uses them, got '{self.configuration}'")
        return self


class SensorConfig(OwnTable):
    """The data sheet of the robots' sensors and bodies, as far as it is told to the robots."""

    pose_noise: NonNegative = 0.0
    """Standard deviation of a fix along x and y [m]."""
    heading_noise: NonNegative = 0.0
    """Standard deviation of the heading of a fix [rad]."""
    actuator_lag: NonNegative = 0.0
    """Time constant with which the body follows a command [s]."""


class LocalizationConfig(OwnTable):
    """The way from fixes to the pose with which a robot computes."""

    filter: Literal["dead_reckoning", "none"] = "dead_reckoning"
    """`dead_reckoning`: the pose follows the robot's own commands, and each new fix corrects it by a share that
    follows from its noise; exact fixes at each tick are the pose itself. `none`: the pose is the fix as sensed, also
    if it is old."""


class FaultConfig(OwnTable):
    """Faults of a robot's transmitter and clock from a tick on; a later entry of the same robot replaces them."""

    tick: int = Field(ge=0)
    """First tick of the faults."""
    robot: int = Field(ge=0)
    """Id of the robot."""
    delay: int = Field(default=0, ge=0, le=MAX_DELAY)
    """Age of the data that its transmitter sends [ticks]."""
    corrupt: bool = False
    """True if its beacons are damaged in transit."""
    skew: Annotated[float, Field(ge=-MAX_SKEW, le=MAX_SKEW)] | None = None
    """Skew of its clock, positive if ahead of the team's [s]; None for the skew drawn from the seed."""


class AgentConfig(OwnTable):
    """The settings that the world sends to an agent when it joins; the agent learns no others."""

    dt: Positive
    """Tick length [s]."""
    seed: int = Field(ge=0)
    """Seed of the robots' own draws; it does not reveal the world's seed."""
    objective: ObjectiveConfig
    """The separations that the team prefers."""
    seeking: SeekingConfig
    """The seeking law."""
    formation: FormationConfig
    """The formation law."""
    channel: ChannelConfig | None
    """The true channel, for laws that are told it."""
    controller: Choice | None = None
    """A whole robot in plain Python, which replaces both laws; none by default."""
    sensors: SensorConfig = SensorConfig()
    """The data sheet of sensors and bodies."""
    localization: LocalizationConfig = LocalizationConfig()
    """The way from fixes to poses."""
    clock: Clock = "lockstep"
    clock_skew: NonNegative = 0.0
    """Largest skew of a robot's own clock [s]; a robot draws its skew from the seed."""
    faults: list[FaultConfig] = Field(default=[])
    """Faults of the robots' own hardware, by tick. They act on the emulated hardware; no law reads them."""


def own(config: AgentConfig, robots: Collection[int]) -> AgentConfig:
    """Configuration for the agent of these robots, with the faults of these robots only."""
    if not config.faults:
        return config
    return config.model_copy(update={"faults": [fault for fault in config.faults if fault.robot in robots]})
