"""The table [run] of a scenario: duration, tick, seed and clock."""

from typing import Annotated, Self

from pydantic import Field, model_validator

from fes.model import counts
from fes.model.config import Clock
from fes.model.seeking import MAX_TICKS
from fes.model.table import Table


class RunConfig(Table):
    """Duration, tick, seed and clock of a run."""

    dt: Annotated[float, Field(ge=1e-6, le=1e3, allow_inf_nan=False)] = 0.02
    """Tick length [s]."""
    duration: Annotated[float, Field(gt=0, le=1e9, allow_inf_nan=False)] = 60.0
    """Simulated time of the run [s], rounded to a whole number of ticks."""
    seed: int = Field(default=0, ge=0, lt=2**63)
    """Seed of every random draw of the run."""
    clock: Clock = "lockstep"
    clock_skew: Annotated[float, Field(ge=0, le=10)] = 0.0
    """Largest skew of a robot's own clock [s]; each robot draws its skew uniformly within it."""

    @model_validator(mode="after")
    def _countable(self) -> Self:
        counts.check("duration / dt", self.duration, self.dt, MAX_TICKS)
        return self
