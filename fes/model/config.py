"""All that an agent may know of a run: it arrives in the Welcome, never from a file.

The world's scenario is built from the same tables. Every model is frozen, complete and rejects unknown
fields. Symbols in brackets are the paper's.
"""

from collections.abc import Collection
from typing import Annotated, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

Exponent = Annotated[float, Field(gt=0, le=20, allow_inf_nan=False)]
"""No channel or objective needs more, and powers stay finite."""

Cutoff = Annotated[float, Field(gt=0, le=1e4, allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NonNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]

Clock = Annotated[
    Literal["lockstep", "live"],
    Field(
        description="`lockstep`: a tick waits for all robots, and simulated time for the slowest. `live`: ticks are "
        "due at times of the wall clock, and wait for no robot."
    ),
]

MAX_DELAY = 10_000
"""Longest delay of a transmitter [ticks]: so much it has to remember."""

MAX_SKEW = 10.0
"""Farthest that a clock may be off [s]."""

MAX_SUB_STEP_PHASE = 2.0
"""Dither phase [rad] that one step of the integration may span before the integration aliases it."""


class Table(BaseModel):
    """A table of a scenario: frozen, complete, strict."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, use_attribute_docstrings=True)


class ChannelConfig(Table):
    """The formula of the radio channel; the truth of the world, and told to an agent only for the oracle index."""

    model: Literal["rayleigh", "logistic", "perfect"] = "rayleigh"
    """`rayleigh`: beacons decode with the probability of (3). `logistic`: with 1 / (1 + exp((r - midpoint) / width)),
    which no exponent of (3) gives. `perfect`: every beacon in range decodes."""
    reference_snr: Positive = 1e7
    """SNR at the reference distance [1] (P0/sigma^2)."""
    spectral_efficiency: Annotated[float, Field(gt=0, le=100, allow_inf_nan=False)] = 2.0
    """Data rate below which the link is in outage [bit/s/Hz] (delta)."""
    path_loss_exponent: Exponent = 3.0
    """Path-loss exponent [1] (nu of (3))."""
    reference_distance: Annotated[float, Field(ge=1e-6, le=1e6)] = 1.0
    """Distance of the reference SNR [m] (r0)."""
    logistic_midpoint: Positive = 100.0
    """Separation at which the logistic channel decodes half of the beacons [m]."""
    logistic_width: Annotated[float, Field(ge=1e-3, le=1e6)] = 12.0
    """Width over which reception falls [m]; its slope at the midpoint is 1 / (4 width) per meter."""
    communication_range: Positive = 150.0
    """Hard cut-off of the radio [m] (r_x)."""


class ObjectiveConfig(Table):
    """Preference for separations; equation (16)."""

    minimum_separation: Positive = 50.0
    """Minimum spacing preferred [m] (r_min)."""
    maximum_separation: Positive = 150.0
    """Spacing of the worst tolerable outage [m] (r_x)."""
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
    """`oracle`: the index is computed from the channel's formula, as the paper's simulation does (33). `measured`: it
    is learnt from the beacons that decode and those that do not; law, gains and filters of (18) are then not used,
    and the dither is physical: the formation breathes with it. `sampled`: the paper's (18) fed with what a real radio
    gives it, J's sample S(r) of a beacon that decoded and 0 of one that did not; also with a physical dither."""
    pooling: Literal["network", "none"] = "network"
    """Of the measured index. `network`: robots mix what they have counted, so that all links teach each. `none`: each
    link learns its own slope, which is better where shadowing makes every link another channel."""
    reference_separation: Positive = 75.0
    """Separation [m] about which measured reception is fitted (rho_0)."""
    law: Literal["consensus", "paper"] = "consensus"
    """`paper`: (18) as printed. `consensus`: with the sign of its second consensus term reversed."""
    index_transform: Literal["log", "none"] = "log"
    """`log`: the robots climb ln J, whose curvature at the optimum hardly depends on the objective, so that one
    gain serves all. `none`: J itself, as printed."""
    index_gain: Positive = 40000.0
    """Gain on the index [1] (k). For J and r_min 50, 44460 = 1/(a^2 |J''|/2) makes the averaged gradient's time
    constant 1 s. Far above the default, or with a far larger dither, cut `sub_step`: estimates that race over meters
    in a step are integrated less exactly.
    """
    dither_amplitude: Positive = 0.2
    """Amplitude of the dither [m] (a)."""
    dither_frequency: Positive = 100.0
    """Frequency of the dither [rad/s] (beta_0)."""
    consensus_gain: Annotated[float, Field(ge=0, le=1e4)] = 4.0
    """Gain of the consensus of estimates [1/s] (kappa); the paper asks for beta_l^2 / 4."""
    low_pass_cutoff: Cutoff = 4.0
    """Cut-off of the low-pass filter [rad/s] (beta_l)."""
    washout_cutoff: Cutoff = 25.0
    """Cut-off of the washout filter [rad/s] (beta_h)."""
    sub_step: Positive = 0.02
    """Longest step of the integration [s]; a tick is cut into equal steps no longer than this."""
    initial_estimate: tuple[Positive, Positive] = Field(default=(50.0, 90.0), strict=False)
    """Estimates of the first links are drawn uniformly from this interval [m]."""

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
    """The formation law (6), (7) and the graph it works on."""

    rule: Literal["disk", "two_nearest", "relative_neighborhood"] = "relative_neighborhood"
    """Rule that chooses neighbors among the robots in range."""
    linear_gain: Positive = 1.0
    """Gain of the linear velocity [1/s] (mu)."""
    angular_gain: Positive = 10.0
    """Gain of the angular velocity [rad/s/m] (mu'); the paper asks for mu' >= mu."""
    linear_limit: Positive | None = None
    """Largest linear speed [m/s]; none by default, as in the paper."""
    angular_limit: Positive | None = None
    """Largest angular speed [rad/s]; none by default, as in the paper."""
    contact_timeout: Annotated[float, Field(gt=0, le=1e6)] = 1.0
    """A peer unheard for this long [s] is no longer a contact."""


class FaultConfig(Table):
    """All that is wrong with a robot's transmitter and clock from a tick on, until the next one of its robot."""

    tick: int = Field(ge=0)
    """From this tick on."""
    robot: int = Field(ge=0)
    """Id of the robot."""
    delay: int = Field(default=0, ge=0, le=MAX_DELAY)
    """Its transmitter sends what it was given so many ticks ago [ticks]."""
    corrupt: bool = False
    """Its beacons are damaged on their way."""
    skew: Annotated[float, Field(ge=-MAX_SKEW, le=MAX_SKEW)] | None = None
    """Lead of its clock over the team's [s]; None: the lead drawn from the seed."""


class AgentConfig(Table):
    """Settings of the run that an agent receives when it joins, and all that it ever knows of them."""

    dt: Positive
    """Tick length [s]."""
    seed: int = Field(ge=0)
    """Seed of the robots' own draws; it does not reveal the world's."""
    objective: ObjectiveConfig
    """Preference for separations."""
    seeking: SeekingConfig
    """The seeking law."""
    formation: FormationConfig
    """The formation law."""
    channel: ChannelConfig | None
    """The true channel, for the oracle index only."""
    clock: Clock = "lockstep"
    clock_skew: NonNegative = 0.0
    """Largest skew of a robot's clock against the team's [s]; each skew is drawn from the seed."""
    faults: list[FaultConfig] = Field(default=[])
    """Faults of the robots' equipment, by tick. They make the equipment fail; no law reads them."""


def own(config: AgentConfig, robots: Collection[int]) -> AgentConfig:
    """The settings for the agent of these robots, with their own faults only."""
    if not config.faults:
        return config
    return config.model_copy(update={"faults": [fault for fault in config.faults if fault.robot in robots]})
