"""Settings of the seeking laws: one table per law. `index` chooses a built-in law, `use` an extension.

Symbols in parentheses are the paper's. A table holds only the keys that its law uses.
"""

import math
from typing import Annotated, Any, ClassVar, Literal, Self, TypeAlias

from pydantic import AfterValidator, BeforeValidator, Discriminator, Field, Tag, model_validator

from fes.model import counts
from fes.model.table import Cutoff, OwnTable, Positive, Use

MAX_SUB_STEP_PHASE = 2.0
"""Largest dither phase per step of the integration [rad]; beyond it the integration aliases the dither."""

MAX_STEPS = 10_000
"""Largest number of integration steps per tick."""

MAX_TICKS = 1e9
"""Largest number of ticks of a run, and of one period of a physical dither."""

MAX_WASHOUT = 100.0
"""Largest washout cut-off times a step of the integration: its quadrature errs by 2e-9 at 100, by 1e-4 at 200."""

NEWTON = 0.3
"""Share of Newton's step that a measured estimate takes in a second (`agents.laws.packet_counting`) [1/s]."""

REFERENCE_SEPARATION = 75.0
"""Separation at which reports compare reception, unless the law has its own [m]."""


class LinkSeekingConfig(OwnTable):
    """The settings that all built-in seeking laws share."""

    dither_amplitude: Positive = 0.2
    """Amplitude of the dither [m] (a)."""
    dither_frequency: Positive = 100.0
    """Frequency of the dither [rad/s] (beta_0)."""
    consensus_gain: Annotated[float, Field(ge=0, le=1e4)] = 4.0
    """Gain of the consensus of estimates [1/s] (kappa); the paper requires beta_l^2 / 4."""
    initial_estimate: tuple[Positive, Positive] = Field(default=(50.0, 90.0), strict=False)
    """Interval from which the estimates of the first links are drawn uniformly [m]."""

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        low, high = self.initial_estimate
        if low > high:
            raise ValueError(f"initial_estimate must be [low, high], got [{low}, {high}]")
        return self

    @property
    def physical_period(self) -> float | None:
        """Period of the oscillation that the law imposes on the formation [s]; None without one."""
        return 2.0 * math.pi / self.dither_frequency

    @property
    def common_dither(self) -> tuple[float, float] | None:
        """Amplitude [m] and frequency [rad/s] of a physical dither that all links share; None without one."""
        return None if self.physical_period is None else (self.dither_amplitude, self.dither_frequency)

    def check(self, dt: float) -> None:
        """Raise ValueError in one line unless ticks of `dt` [s] suit these settings."""
        if self.physical_period is not None:
            counts.check("the period of seeking.dither_frequency / run.dt", self.physical_period, dt, MAX_TICKS)


class PerturbationConfig(LinkSeekingConfig):
    """The settings of (18)."""

    law: Literal["consensus", "paper"] = "consensus"
    """Seeking law. `paper`: (18) as printed. `consensus`: (18) with the sign of its second consensus term
    reversed."""
    index_gain: Positive = 40000.0
    """Gain on the index [1] (k). For J and r_min 50, 44460 = 1/(a^2 |J''|/2) makes the averaged gradient's time
    constant 1 s. With a gain or a dither far above the default, reduce `sub_step`: estimates that move by meters per
    step are integrated less exactly.
    """
    low_pass_cutoff: Cutoff = 4.0
    """Cut-off of the low-pass filter [rad/s] (beta_l)."""
    washout_cutoff: Cutoff = 25.0
    """Cut-off of the washout filter [rad/s] (beta_h)."""
    sub_step: Positive = 0.02
    """Longest step of the integration [s]; a tick is divided into equal steps no longer than this."""

    @model_validator(mode="after")
    def _bounds(self) -> Self:
        if self.sub_step * self.dither_frequency > MAX_SUB_STEP_PHASE:
            raise ValueError(
                f"sub_step x dither_frequency must be at most {MAX_SUB_STEP_PHASE} rad, "
                f"got {self.sub_step * self.dither_frequency:g}"
            )
        for name in ("low_pass_cutoff", "consensus_gain"):
            if getattr(self, name) * self.sub_step > 1.0:
                raise ValueError(f"sub_step x {name} must be at most 1, got {getattr(self, name) * self.sub_step:g}")
        return self

    def check(self, dt: float) -> None:
        """Raise ValueError in one line unless ticks of `dt` [s] suit these settings."""
        counts.check("run.dt / seeking.sub_step", dt, self.sub_step, MAX_STEPS)
        super().check(dt)
        reached = self.washout_cutoff * dt / counts.steps(dt, self.sub_step)
        if reached > MAX_WASHOUT:
            raise ValueError(
                f"seeking.washout_cutoff x a step of the integration must be at most {MAX_WASHOUT:g}, got {reached:g}"
            )


class OracleConfig(PerturbationConfig):
    """(18) with the paper's shortcut (33): the index is computed from the channel's formula."""

    knows_channel: ClassVar[bool] = True

    index: Literal["oracle"] = "oracle"
    """Source of the performance index. `oracle`: computed from the channel's formula, as in the paper's simulation
    (33). `measured`: learnt from the beacons that decode and those that are lost. Of the gains and filters of (18),
    only the consensus gain is then used. The dither is physical: the formation oscillates with it. `sampled`: (18)
    with samples of J, S(r) for a decoded beacon and 0 for a lost one; the dither is physical too."""
    index_transform: Literal["log", "none"] = "log"
    """Transform of the index. `log`: the robots climb ln J, whose curvature at the optimum hardly depends on the
    objective, so that one gain serves all objectives. `none`: they climb J, as printed."""

    @property
    def physical_period(self) -> float | None:
        """None: the robots compute the index at the dithered separations, and do not drive there."""
        return None


class SampledConfig(PerturbationConfig):
    """(18) with samples of J."""

    knows_channel: ClassVar[bool] = False

    index: Literal["sampled"]
    """Source of the performance index: samples of J."""
    index_transform: Literal["none"] = "none"
    """Transform of the index: none, because a lost beacon's sample is 0."""


class MeasuredConfig(LinkSeekingConfig):
    """The index measured by counting beacons."""

    knows_channel: ClassVar[bool] = False

    index: Literal["measured"]
    """Source of the performance index: counted beacons."""
    pooling: Literal["network", "none"] = "network"
    """Pooling of the measured index. `network`: robots mix their counts of beacons, so that each learns from all
    links. `none`: each link learns its own slope, which is better under shadowing."""
    reference_separation: Positive = REFERENCE_SEPARATION
    """Separation about which measured reception is fitted [m] (rho_0)."""

    @property
    def common_dither(self) -> tuple[float, float] | None:
        """None without pooling: each link then has a phase of its own."""
        return super().common_dither if self.pooling == "network" else None

    def check(self, dt: float) -> None:
        """Raise ValueError in one line unless ticks of `dt` [s] suit these settings.

        Estimates step by Euler: r_ij += dt [kappa (r_ji of a tick before - r_ij) - 0.3 G/H]. The disagreement
        follows d(k+1) = (1 - (kappa + g) dt) d(k) - kappa dt d(k-1), g <= 0.3 /s. By Jury's criterion it decays iff
        kappa dt < 1 and g dt < 2.
        """
        super().check(dt)
        counts.below("seeking.consensus_gain x run.dt of a measured index", self.consensus_gain * dt, 1.0)
        counts.below(f"{NEWTON:g} /s x run.dt of a measured index", NEWTON * dt, 2.0)


BUILT_IN: dict[str, type[OracleConfig | SampledConfig | MeasuredConfig]] = {
    "oracle": OracleConfig,
    "measured": MeasuredConfig,
    "sampled": SampledConfig,
}
"""`index` -> the settings of its law."""

_FORMER = {
    name: field.default for kind in BUILT_IN.values() for name, field in kind.model_fields.items() if name != "index"
} | {"index_transform": "log"}
"""Keys of the single table of fes 0.3, with their defaults. It wrote all of them, also those that the law ignored."""


def without_unused(table: Any) -> Any:
    """The table without keys that its law does not use, if these have the default of fes 0.3.

    Raises ValueError for one with another value: it would have no effect.
    """
    if not isinstance(table, dict) or "use" in table:
        return table
    kind = BUILT_IN.get(str(table.get("index", "oracle")))
    if kind is None:
        return table
    unused = {name: value for name, value in table.items() if name in _FORMER and name not in kind.model_fields}
    for name, value in unused.items():
        if (tuple(value) if isinstance(value, list) else value) != _FORMER[name]:
            raise ValueError(f"{name} is not used with index '{table.get('index', 'oracle')}': leave it out")
    return {name: value for name, value in table.items() if name not in unused}


def _not_an_index(choice: Use) -> Use:
    """The choice; raises ValueError for the law of an index, whose table checks rules that an extension has not."""
    index = choice.use.partition(",")[0]
    if index in BUILT_IN:
        raise ValueError(f"use names an extension, and '{choice.use}' is built in: write index = '{index}'")
    return choice


def _tag(table: Any) -> str:
    if isinstance(table, Use):
        return "use="
    if isinstance(table, dict):
        return "use=" if "use" in table else f"index={table.get('index', 'oracle')!s:.40}"
    return f"index={getattr(table, 'index', None)}"


SeekingConfig: TypeAlias = Annotated[
    Annotated[OracleConfig, Tag("index=oracle")]
    | Annotated[MeasuredConfig, Tag("index=measured")]
    | Annotated[SampledConfig, Tag("index=sampled")]
    | Annotated[Use, AfterValidator(_not_an_index), Tag("use=")],
    Discriminator(
        _tag,
        custom_error_type="index",
        custom_error_message="index must be 'oracle', 'measured' or 'sampled'; `use` names an extension",
    ),
    BeforeValidator(without_unused),
]
"""The table [seeking]."""
