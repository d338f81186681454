"""The crew of a process: from the observations and beacons of a tick to the payloads that answer it."""

import numpy as np

from agents.control import crew, transmitter
from agents.control.transmitter import RobotPayloads
from agents.runtime import marshalling
from agents.runtime.marshalling import MessageAssembler
from agents.runtime.model_freedom import is_model_free
from agents.runtime.reception import Receiver
from fes.model.sensing import Observations
from fes.protocol.messages import Beacon, Observation, Welcome


class HostedCrew:
    """The robots of one Welcome, and their state."""

    def __init__(self, welcome: Welcome) -> None:
        ids = np.array(welcome.robots, dtype=np.int64)
        self._crew = crew.create(welcome.config, ids)
        self._state = crew.start(self._crew)
        self._assembler, self._receiver = MessageAssembler(ids), Receiver()
        self._since = [0] * len(ids)
        """Tick from which each robot takes part."""

    def observe(self, received: list[Observation]) -> Observations:
        """The observations of one tick, one per robot in id order, as arrays; robots that were absent start anew."""
        joined = [message.since for message in received]
        if joined != self._since:
            was_absent = np.array(joined) != np.array(self._since)
            self._state, self._since = crew.forget(self._crew, self._state, was_absent), joined
        return self._assembler.observations(received)

    def answer(self, observations: Observations, heard: list[Beacon]) -> list[RobotPayloads]:
        """The payloads of the tick of `observations`, after the beacons `heard` of the previous tick.

        The beacons are ordered by sender. Raises FesError for a twist that is not finite.
        """
        beacons = self._assembler.beacons(observations.tick - 1, heard)
        received = self._receiver.receive(observations, beacons, self._state.contacts.edges)
        self._state, sent, twists, telemetry = crew.step(self._crew, self._state, observations.sensed, received)
        telemetry = telemetry._replace(is_model_free=is_model_free())
        payloads = marshalling.encode_tick(sent, twists, telemetry)
        return transmitter.on_air(self._crew.transmitters, observations.tick, payloads)
