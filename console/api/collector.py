"""The arrays of a run, collected tick by tick, while it runs or while its log is read."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from console.api.result import LinkTable, Run
from fes.arrays.edges import Edges
from fes.arrays.types import Ints
from fes.model.sensing import DECODED, Telemetry
from world.config.scenario import Scenario
from world.metrics import link_errors
from world.simulation.channel import Radio
from world.simulation.truth import State

GROWTH = 1.5
"""Factor by which an array grows when it is full."""


class TickCollector:
    """Poses, twists and links of a run; call `add` once per tick, in order."""

    def __init__(self, robots: int) -> None:
        self._poses = _Rows(np.float64, robots, 3)
        self._twists = _Rows(np.float64, robots, 2)
        self._tick, self._robot, self._peer = _Rows(np.int64), _Rows(np.int64), _Rows(np.int64)
        self._separation, self._estimate, self._outage = (_Rows(np.float64) for _ in range(3))
        self._decoded = _Rows(np.bool_)
        self._positions = _Positions()

    def add(self, state: State, twists: NDArray[np.float64], telemetry: Telemetry) -> None:
        """Add a tick: the state, the twists [n, 2] that the bodies hold, and the robots' telemetry."""
        self._poses.extend(state.poses[None])
        self._twists.extend(twists[None])
        links = telemetry.links
        if not len(links):
            return
        self._tick.extend(np.full(len(links), state.tick))
        self._robot.extend(links.robots)
        self._peer.extend(links.peers)
        self._separation.extend(link_errors.separations(state.poses, links.robots, links.peers))
        self._estimate.extend(telemetry.estimates)
        outage, decoded = self._fate(links, state.radio)
        self._outage.extend(outage)
        self._decoded.extend(decoded)

    def run(self, scenario: Scenario, summary: dict[str, Any], directory: Path | None) -> Run:
        """The run; the collector is then empty."""
        poses = self._poses.take()
        links = LinkTable(
            self._tick.take(),
            self._robot.take(),
            self._peer.take(),
            self._separation.take(),
            self._estimate.take(),
            self._outage.take(),
            self._decoded.take(),
        )
        time = scenario.run.dt * np.arange(len(poses), dtype=np.float64)
        return Run(scenario, summary, time, poses, self._twists.take(), links, directory)

    def _fate(self, links: Edges, radio: Radio) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
        """Outage probability of the beacon on each link, NaN without a contact, and True if it decoded [l]."""
        if not len(radio.edges):
            return np.full(len(links), np.nan), np.zeros(len(links), dtype=np.bool_)
        positions = self._positions.of(links, radio.edges)
        is_contact = positions >= 0
        outage = np.where(is_contact, 1.0 - radio.probability.take(positions), np.nan)
        return outage, is_contact & (radio.reception.take(positions) == DECODED)


class _Positions:
    """Positions of links among contacts, looked up again only when either changes."""

    def __init__(self) -> None:
        self._links: Edges | None = None
        self._contacts: Edges | None = None
        self._positions: Ints = np.zeros(0, dtype=np.int64)

    def of(self, links: Edges, contacts: Edges) -> Ints:
        """Position of each link among the contacts, or -1 [l]."""
        if links is not self._links or contacts is not self._contacts:
            self._links, self._contacts = links, contacts
            self._positions = links.after(contacts).positions
        return self._positions


class _Rows:
    """An array that grows along its first axis."""

    def __init__(self, kind: type[np.generic], *shape: int) -> None:
        self._shape = shape
        self._data: NDArray[Any] = np.empty((0, *shape), dtype=kind)
        self._length = 0

    def extend(self, rows: NDArray[Any]) -> None:
        """Add rows at its end."""
        end = self._length + len(rows)
        if end > len(self._data):
            self._resize(max(end, int(GROWTH * end)))
        self._data[self._length : end] = rows
        self._length = end

    def take(self) -> NDArray[Any]:
        """All rows, in memory of exactly their size."""
        self._resize(self._length)
        return self._data

    def _resize(self, length: int) -> None:
        self._data.resize((length, *self._shape), refcheck=False)  # in place: it never exists twice
