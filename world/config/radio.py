"""The world's radio: the channel's formula, and what no robot is ever told of it: a scenario's table [channel]."""

from itertools import chain
from typing import Annotated, Self

from pydantic import Field, model_validator

from fes.model.config import ChannelConfig, Positive, Table

Finite = Annotated[float, Field(allow_inf_nan=False)]


class ShadowingConfig(Table):
    """Log-normal shadowing, correlated in space; `world.simulation.shadowing`."""

    deviation: Annotated[float, Field(ge=0, le=50)]
    """Standard deviation of the gain [dB]; 4 to 8 in the open, up to 12 in towns."""
    decorrelation_distance: Annotated[float, Field(ge=1e-3, le=1e6)] = 20.0
    """Distance over which the correlation falls to 1/e [m]; Gudmundson 1991 measured 5 m in towns, 500 m outside."""


class BurstConfig(Table):
    """Losses that come in bursts: a Gilbert-Elliott chain on each directed contact; `world.simulation.bursts`."""

    bad_share: Annotated[float, Field(gt=0, lt=1)]
    """Share of the time that a contact is in its bad state [1]."""
    mean_length: Positive
    """Mean length of a stay in the bad state [s]."""
    loss: Annotated[float, Field(ge=0, le=1)] = 1.0
    """Probability that a beacon which would decode is lost in the bad state [1]."""


class JammerConfig(Table):
    """A disc in which receivers hear less."""

    x: Finite
    """x of its center [m; world frame]."""
    y: Finite
    """y of its center [m; world frame]."""
    radius: Positive
    """Its radius [m]."""
    reception_factor: Annotated[float, Field(ge=0, le=1)] = 0.0
    """What it leaves of the reception probability of a receiver inside [1]; discs that overlap multiply."""


class RadioConfig(ChannelConfig):
    """The radio as it truly is: the formula, and what may be laid over it."""

    shadowing: ShadowingConfig | None = None
    """Log-normal shadowing; none by default."""
    bursts: BurstConfig | None = None
    """Losses in bursts; none by default."""
    jammers: list[JammerConfig] = Field(default=[])
    """Discs in which receivers hear less."""
    partition: list[list[Annotated[int, Field(ge=0)]]] = Field(default=[])
    """Groups of robots between which no beacon decodes; those in none are one more group."""

    @model_validator(mode="after")
    def _each_once(self) -> Self:
        named = list(chain.from_iterable(self.partition))
        twice = {robot for robot in named if named.count(robot) > 1}
        if twice:
            raise ValueError(f"partition: robot {min(twice)} is there twice")
        return self

    @property
    def formula(self) -> ChannelConfig:
        """What may be told to an oracle."""
        return ChannelConfig.model_validate(self.model_dump(include=set(ChannelConfig.model_fields)))

    @property
    def is_certain(self) -> bool:
        """Whether every beacon in range decodes."""
        return self.model == "perfect" and self.bursts is None and not (self.jammers or self.partition)

    def check(self, dt: float) -> None:
        """Raises ValueError if ticks of `dt` [s] are too long for the chain of the bursts."""
        if self.bursts is None:
            return
        length, share = self.bursts.mean_length, self.bursts.bad_share
        if length < dt:
            raise ValueError(f"channel.bursts.mean_length must be at least run.dt, {dt:g} s, got {length:g}")
        if dt * share > length * (1.0 - share):
            raise ValueError(
                "channel.bursts.mean_length must be at least run.dt x bad_share / (1 - bad_share), "
                f"{dt * share / (1.0 - share):g} s, got {length:g}"
            )
