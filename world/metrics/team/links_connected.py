"""Connection of the team by the robots' links."""

from fes.extension.context import WorldContext
from fes.extension.protocols import NoParameters
from world.metrics.link_errors import Graph
from world.metrics.tick_truth import TickTruth


class LinksConnected:
    """The share of ticks at which the links connect all robots present, and whether they do at the last one."""

    Parameters = NoParameters

    def __init__(self, parameters: NoParameters, context: WorldContext) -> None:
        self._graph = Graph()
        self._ticks = self._connected = 0

    def add(self, tick: TickTruth) -> None:
        """Add a tick."""
        self._ticks += 1
        self._connected += self._graph.is_connected(tick.telemetry.links, tick.state.present)

    def result(self) -> dict[str, float | None]:
        """The share of all ticks [1], and 1 if the links connect the team at the last tick, else 0."""
        if not self._ticks:
            return {"share": None, "at_end": None}
        return {"share": self._connected / self._ticks, "at_end": float(self._graph.connected)}
