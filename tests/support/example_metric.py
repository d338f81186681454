"""A metric as somebody else writes it."""

from typing import Any

from fes.extension import NoParameters, WorldContext


class Count:
    """Number of ticks, and a number that it never has."""

    Parameters = NoParameters

    def __init__(self, parameters: NoParameters, context: WorldContext) -> None:
        self.ticks = 0

    def add(self, tick: Any) -> None:
        """Add a tick."""
        self.ticks += 1

    def result(self) -> dict[str, float | None]:
        """The numbers up to the last tick."""
        return {"ticks": float(self.ticks), "nothing": None}
