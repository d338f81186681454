"""Configuration of an agent: all that it may know of a run. It arrives in the Welcome, never from a file.

The world's scenario consists of the same tables. Every model is frozen, complete and rejects unknown fields. Symbols
in parentheses are the paper's. The docstring of a field is its description in `fes schema`, and names its unit in
brackets.
"""

from collections.abc import Collection
from typing import Annotated, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

Exponent = Annotated[float, Field(gt=0, le=20, allow_inf_nan=False)]
"""Bounded, so that powers stay finite; larger exponents have no use."""

Cutoff = Annotated[float, Field(gt=0, le=1e4, allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NonNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]

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

MAX_SUB_STEP_PHASE = 2.0
"""Largest dither phase per step of the integration [rad]; beyond it the integration aliases the dither."""


class Table(BaseModel):
    """A table of a scenario: frozen, complete, strict."""

    # Without use_attribute_docstrings, which parses the source at each start: world.config.schema reads it on demand.
    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)


class ChannelConfig(Table):
    """The formula of the radio channel: the truth of the world. An agent gets it for the oracle index only."""

    model: Literal["rayleigh", "logistic", "perfect"] = "rayleigh"
    """Reception model. `rayleigh`: beacons decode with the probability of (3). `logistic`: with
    1 / (1 + exp((r - midpoint) / width)), a shape that no exponent gives (3). `perfect`: every beacon in range
    decodes."""
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


class ObjectiveConfig(Table):
    """The separations that the team prefers, by equation (16)."""

    minimum_separation: Positive = 50.0
    """Smallest separation that the team prefers [m] (r_min)."""
    maximum_separation: Positive = 150.0
    """Separation with the largest tolerable outage [m] (r_x)."""
    shape_exponent: Exponent = 4.0
    """Shape exponent of the index [1] (nu of (16); Fig. 3 has 4)."""

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.minimum_separation >= self.maximum_separation:
            raise ValueError(
                f"minimum_separation must be below maximum_separation, "
                f"got {self.minimum_separation:g} and {self.maximum_separation:g}"
            )
        return self


class SeekingConfig(Table):
    """The seeking law (18)."""

    index: Literal["oracle", "measured", "sampled"] = "oracle"
    """Source of the performance index. `oracle`: computed from the channel's formula, as in the paper's simulation
    (33). `measured`: learnt from the beacons that decode and those that are lost. Of the gains and filters of (18),
    only the consensus gain is then used. The dither is physical: the formation oscillates with it. `sampled`: (18)
    with samples of J, S(r) for a decoded beacon and 0 for a lost one; the dither is physical too."""
    pooling: Literal["network", "none"] = "network"
    """Pooling of the measured index. `network`: robots mix their counts of beacons, so that each learns from all
    links. `none`: each link learns its own slope, which is better under shadowing."""
    reference_separation: Positive = 75.0
    """Separation about which measured reception is fitted [m] (rho_0)."""
    law: Literal["consensus", "paper"] = "consensus"
    """Seeking law. `paper`: (18) as printed. `consensus`: (18) with the sign of its second consensus term
    reversed."""
    index_transform: Literal["log", "none"] = "log"
    """Transform of the index. `log`: the robots climb ln J, whose curvature at the optimum hardly depends on the
    objective, so that one gain serves all objectives. `none`: they climb J, as printed."""
    index_gain: Positive = 40000.0
    """Gain on the index [1] (k). For J and r_min 50, 44460 = 1/(a^2 |J''|/2) makes the averaged gradient's time
    constant 1 s. With a gain or a dither far above the default, reduce `sub_step`: estimates that move by meters per
    step are integrated less exactly.
    """
    dither_amplitude: Positive = 0.2
    """Amplitude of the dither [m] (a)."""
    dither_frequency: Positive = 100.0
    """Frequency of the dither [rad/s] (beta_0)."""
    consensus_gain: Annotated[float, Field(ge=0, le=1e4)] = 4.0
    """Gain of the consensus of estimates [1/s] (kappa); the paper requires beta_l^2 / 4."""
    low_pass_cutoff: Cutoff = 4.0
    """Cut-off of the low-pass filter [rad/s] (beta_l)."""
    washout_cutoff: Cutoff = 25.0
    """Cut-off of the washout filter [rad/s] (beta_h)."""
    sub_step: Positive = 0.02
    """Longest step of the integration [s]; a tick is divided into equal steps no longer than this."""
    initial_estimate: tuple[Positive, Positive] = Field(default=(50.0, 90.0), strict=False)
    """Interval from which the estimates of the first links are drawn uniformly [m]."""

    @model_validator(mode="after")
    def _bounds(self) -> Self:
        low, high = self.initial_estimate
        if self.index == "sampled" and self.index_transform != "none":
            raise ValueError("index 'sampled' needs index_transform 'none': a lost beacon's sample is 0")
        if low > high:
            raise ValueError(f"initial_estimate must be [low, high], got [{low}, {high}]")
        if self.sub_step * self.dither_frequency > MAX_SUB_STEP_PHASE:
            raise ValueError(
                f"sub_step x dither_frequency must be at most {MAX_SUB_STEP_PHASE} rad, "
                f"got {self.sub_step * self.dither_frequency:g}"
            )
        for name in ("low_pass_cutoff", "consensus_gain"):
            if getattr(self, name) * self.sub_step > 1.0:
                raise ValueError(f"sub_step x {name} must be at most 1, got {self.sub_step * getattr(self, name):g}")
        return self


class FormationConfig(Table):
    """The formation law (6), (7) and its graph."""

    rule: Literal["disk", "two_nearest", "relative_neighborhood"] = "relative_neighborhood"
    """Neighbor rule, which selects the links among the robots in range. `disk`: all of them. `two_nearest`: the two
    nearest. `relative_neighborhood`: those without a third robot nearer to both ends."""
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


class FaultConfig(Table):
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


class AgentConfig(Table):
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
    """The true channel, for the oracle index only."""
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
