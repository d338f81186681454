"""The crew of a process: from the observations and beacons of a tick to the payloads that answer it."""

from collections.abc import Sequence

import numpy as np

from agents.control import crew, transmitter
from agents.control.transmitter import RobotPayloads
from agents.core.byte_crew import ByteCrew
from agents.runtime import marshalling
from agents.runtime.crew_run import CrewRun
from agents.runtime.marshalling import MessageAssembler
from agents.runtime.model_freedom import is_model_free
from fes.model.sensing import Observations
from fes.protocol import wire
from fes.protocol.messages import Beacon, Observation, Welcome


class HostedCrew:
    """The robots of one Welcome, and their state."""

    def __init__(self, welcome: Welcome) -> None:
        ids = np.array(welcome.robots, dtype=np.int64)
        self._crew = CrewRun(crew.create(welcome.config, ids))
        self._assembler = MessageAssembler(ids)
        self._since = np.zeros(len(ids), dtype=np.int64)
        """Tick from which each robot takes part [n]."""
        compiled = self._crew.compiled
        is_read = compiled is not None and self._crew.crew.localizer.is_exact
        self._bytes = ByteCrew(compiled, wire.PROTOCOL) if compiled is not None and is_read else None

    @property
    def is_compiled(self) -> bool:
        """True if the compiled core moves this crew."""
        return self._crew.compiled is not None

    @property
    def peers(self) -> frozenset[int]:
        """The peers in range of any robot, at the last tick that `answer_bytes` answered; one object while they are
        the same."""
        return frozenset() if self._bytes is None else self._bytes.peers

    def answer_bytes(
        self, tick: int, observations: Sequence[bytes], beacons: Sequence[bytes]
    ) -> list[RobotPayloads] | None:
        """The payloads that answer the observations of a tick, of the robots in id order, in one call of the core.

        `beacons` are those of the tick before, ordered by sender. None, and no change, where a message is unusual in
        any way, a robot was absent, or a beacon is missing: `observe` and `answer` are for all ticks.
        """
        if self._bytes is None or not self.is_compiled:
            return None
        payloads = self._bytes.step(tick, observations, beacons, self._since, is_model_free())
        if payloads is None:
            return None
        self._crew.at_fixes(tick)
        return transmitter.on_air(self._crew.crew.transmitters, tick, payloads)

    def observe(self, received: list[Observation]) -> Observations:
        """The observations of one tick, one per robot in id order, as arrays; robots that were absent start anew."""
        joined = np.array([message.since for message in received], dtype=np.int64)
        if (was_absent := joined != self._since).any():
            self._crew.forget(was_absent)
            self._since = joined
        return self._assembler.observations(received)

    def answer(self, observations: Observations, heard: list[Beacon]) -> list[RobotPayloads]:
        """The payloads of the tick of `observations`, after the beacons `heard` of the previous tick.

        The beacons are ordered by sender. Raises FesError for a twist that is not finite.
        """
        beacons = self._assembler.beacons(observations.tick - 1, heard)
        sent, twists, telemetry = self._crew.step(observations, beacons)
        telemetry = telemetry._replace(is_model_free=is_model_free())
        payloads = marshalling.encode_tick(sent, twists, telemetry)
        return transmitter.on_air(self._crew.crew.transmitters, observations.tick, payloads)
