"""The world's radio, a scenario's table [channel]: the formula, and effects that the robots do not know."""

from itertools import chain, pairwise
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from fes.model.config import ChannelConfig
from fes.model.table import Positive, Table

Distance = Annotated[float, Field(ge=0, le=1e6)]
Share = Annotated[float, Field(ge=0, le=1)]
Finite = Annotated[float, Field(allow_inf_nan=False)]


class ShadowingConfig(Table):
    """Log-normal shadowing, correlated in space, see `world.simulation.shadowing`."""

    deviation: Annotated[float, Field(ge=0, le=50)]
    """Standard deviation of the gain [dB]: 4 to 8 in open terrain, up to 12 in towns."""
    decorrelation_distance: Annotated[float, Field(ge=1e-3, le=1e6)] = 20.0
    """Distance at which the correlation is 1/e [m]; Gudmundson (1991) measured 5 m in towns, 500 m in suburbs."""


class BurstConfig(Table):
    """Losses in bursts: a Gilbert-Elliott chain per directed contact, see `world.simulation.bursts`."""

    bad_share: Annotated[float, Field(gt=0, lt=1)]
    """Share of time that a contact spends in its bad state [1]."""
    mean_length: Positive
    """Mean length of a stay in the bad state [s]."""
    loss: Annotated[float, Field(ge=0, le=1)] = 1.0
    """Probability that the bad state loses a beacon that would decode [1]."""


class JammerConfig(Table):
    """A disc in which reception is reduced."""

    x: Finite
    """x coordinate of its center [m; world frame]."""
    y: Finite
    """y coordinate of its center [m; world frame]."""
    radius: Positive
    """Radius of the disc [m]."""
    reception_factor: Annotated[float, Field(ge=0, le=1)] = 0.0
    """Factor on the reception probability of a receiver inside [1]; factors of overlapping discs multiply."""


class RadioConfig(ChannelConfig):
    """The true radio channel: the formula, and optional effects on top of it."""

    rows: list[Annotated[tuple[Distance, Share], Field(strict=False)]] = Field(default=[])
    """Rows of the model `table`: separation and reception probability [m, 1], sorted by separation. The probability
    is interpolated between rows and constant beyond them. It need not fall with separation."""
    trace: str | None = None
    """File of the model `trace`, by its path from the scenario's file: comma-separated, with a line of names. The
    columns are time in seconds, sender, receiver, and probability or decoded. The path of a `--set` starts from the
    current directory."""
    trace_between: Literal["held", "interpolated"] = "held"
    """Value between two times of a trace. `held`: the earlier value. `interpolated`: on the line between both."""
    trace_sha256: str | None = None
    """SHA-256 of the trace, filled in when it is first read: the run can be repeated only with the same file."""
    shadowing: ShadowingConfig | None = None
    """Log-normal shadowing; none by default."""
    bursts: BurstConfig | None = None
    """Losses in bursts; none by default."""
    jammers: list[JammerConfig] = Field(default=[])
    """Discs in which reception is reduced."""
    partition: list[list[Annotated[int, Field(ge=0)]]] = Field(default=[])
    """Groups of robot ids between which no beacon decodes; all robots in no group form one more group."""

    @model_validator(mode="after")
    def _each_once(self) -> Self:
        members = list(chain.from_iterable(self.partition))
        repeated = {robot for robot in members if members.count(robot) > 1}
        if repeated:
            raise ValueError(f"partition: robot {min(repeated)} is listed twice")
        return self

    @model_validator(mode="after")
    def _complete(self) -> Self:
        if self.model == "table" and len(self.rows) < 2:
            raise ValueError(f"rows: model 'table' needs at least two, got {len(self.rows)}")
        separations = [separation for separation, _ in self.rows]
        for before, after in pairwise(separations):
            if after <= before:
                raise ValueError(f"rows: separations must ascend, got {before:g} and then {after:g}")
        if self.model == "trace" and self.trace is None:
            raise ValueError("model 'trace' needs the path of a file, `trace`")
        if self.model == "trace" and self.shadowing is not None:
            raise ValueError("shadowing acts on separations, which a trace does not have")
        return self

    @property
    def formula(self) -> ChannelConfig:
        """The formula alone, which an oracle may know."""
        return ChannelConfig.model_validate(self.model_dump(include=set(ChannelConfig.model_fields)))

    @property
    def is_certain(self) -> bool:
        """True if every beacon in range decodes."""
        return self.model == "perfect" and self.bursts is None and not (self.jammers or self.partition)

    def check(self, dt: float) -> None:
        """Raise ValueError if ticks of `dt` [s] are too long for the chain of the bursts."""
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
