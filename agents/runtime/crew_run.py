"""A crew during a run: its state from tick to tick, moved by the compiled core or by numpy, with the same digits.

The core computes with poses that are the fixes. Where they are not, because the sensors are noisy, or late, or slow,
`agents.control.localization` computes the poses, and the core does the rest.
"""

from dataclasses import replace

from agents.control import crew, localization
from agents.control.localization import Located
from agents.control.state import Crew, CrewState
from agents.core import compiled_crew
from agents.core.compiled_crew import CompiledCrew, Failed, Sent
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
        self._located: Located | None = None
        """Of a crew that the core moves; None while the poses in its state are the fixes."""
        self._tick = localization.NEVER
        """The last tick at which they were."""
        self._writer: PayloadWriter | None = None

    @property
    def state(self) -> CrewState:
        """The state now."""
        if self.compiled is None:
            return self._state
        return self.compiled.state._replace(located=self._where(self.compiled))

    def forget(self, restarted: Bools) -> None:
        """Let the robots `restarted` [n] know nothing, as if their process had just started."""
        if self.compiled is None:
            self._state = crew.forget(self.crew, self._state, restarted)
            return
        self._located = localization.forget(self._where(self.compiled), restarted)
        self.compiled.forget(restarted)

    def at_fixes(self, tick: int) -> None:
        """Note that the compiled crew has made this tick, with poses that are the fixes."""
        self._tick, self._located = tick, None

    def step(self, observations: Observations, beacons: Beacons) -> Sent:
        """One tick, from the observations and the `beacons` of the tick before; those that did not decode have no
        effect.

        Raises FesError for a twist that is not finite.
        """
        if self.compiled is not None:
            try:
                return self._step_compiled(self.compiled, observations, beacons)
            except Failed:  # numpy knows the reason
                self._state, self.compiled = self.state, None
        received = self._receiver.receive(observations, beacons, self._state.contacts.edges)
        self._state, sent, twists, telemetry = crew.step(self.crew, self._state, observations.sensed, received)
        return Sent(sent, twists, telemetry)

    def payloads(self, sent: Sent, since: Ints, present: Bools, decodable: Bools) -> Written | None:
        """The messages of a tick, as `PayloadWriter.write` has them.

        None where numpy moves the crew, if its poses are not the fixes, or if `sent` is not the output of its last
        tick.
        """
        if self.compiled is None or self._located is not None or not self.compiled.has_sent(sent.beacons):
            return None
        if self._writer is None:
            self._writer = PayloadWriter(self.compiled, wire.PROTOCOL)
        return self._writer.write(since, present, decodable, sent.telemetry.is_model_free)

    def _step_compiled(self, compiled: CompiledCrew, observations: Observations, beacons: Beacons) -> Sent:
        """One tick of the core; raises Failed, and the state is then that before the tick."""
        sensed, localizer = observations.sensed, self.crew.localizer
        if localizer.is_exact and localization.is_fixed(sensed):
            result = compiled.step(observations, beacons)
            self.at_fixes(observations.tick)
            return result
        located = localization.locate(localizer, self._where(compiled), sensed)
        result = compiled.step(replace(observations, poses=located.poses, fixed=None), beacons)
        self._located = localization.command(located, result.twists)
        return result

    def _where(self, compiled: CompiledCrew) -> Located:
        """The localization of the compiled crew."""
        if self._located is not None:
            return self._located
        return localization.at_fixes(self._tick, *compiled.last)
