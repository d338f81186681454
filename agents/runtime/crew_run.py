"""A crew during a run: its state from tick to tick, moved by the compiled core or by numpy, with the same digits."""

from agents.control import crew
from agents.control.state import Crew, CrewState
from agents.core import compiled_crew
from agents.core.compiled_crew import Failed, Sent
from agents.core.payload_writer import PayloadWriter, Written
from agents.runtime.reception import Receiver
from fes.arrays.types import Bools, Ints
from fes.model.sensing import Beacons, Observations
from fes.protocol import wire


class CrewRun:
    """The state of a crew, from its start on."""

    def __init__(self, robots: Crew) -> None:
        self.crew = robots
        self.compiled = compiled_crew.of(robots)
        """The compiled crew; None where numpy moves it."""
        self._state, self._receiver = crew.start(robots), Receiver()
        """Of a crew that numpy moves."""
        self._writer: PayloadWriter | None = None

    @property
    def state(self) -> CrewState:
        """The state now."""
        return self._state if self.compiled is None else self.compiled.state

    def forget(self, restarted: Bools) -> None:
        """Let the robots `restarted` [n] know nothing, as if their process had just started."""
        if self.compiled is not None:
            self.compiled.forget(restarted)
        else:
            self._state = crew.forget(self.crew, self._state, restarted)

    def step(self, observations: Observations, beacons: Beacons) -> Sent:
        """One tick, from the observations and the `beacons` of the tick before; those that did not decode have no
        effect.

        Raises FesError for a twist that is not finite.
        """
        if self.compiled is not None:
            try:
                return self.compiled.step(observations, beacons)
            except Failed:  # numpy knows the reason
                self._state, self.compiled = self.compiled.state, None
        received = self._receiver.receive(observations, beacons, self._state.contacts.edges)
        self._state, sent, twists, telemetry = crew.step(self.crew, self._state, observations.sensed, received)
        return Sent(sent, twists, telemetry)

    def payloads(self, sent: Sent, since: Ints, present: Bools, decodable: Bools) -> Written | None:
        """The messages of a tick, as `PayloadWriter.write` has them.

        None where numpy moves the crew, or if `sent` is not the output of its last tick.
        """
        if self.compiled is None or not self.compiled.has_sent(sent.beacons):
            return None
        if self._writer is None:
            self._writer = PayloadWriter(self.compiled, wire.PROTOCOL)
        return self._writer.write(since, present, decodable, sent.telemetry.is_model_free)
