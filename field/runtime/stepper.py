"""One tick of a real robot: from its fix and what its radio has heard to its beacon and its command."""

from typing import NamedTuple

from agents.runtime.hosted_crew import HostedCrew
from fes.model.config import AgentConfig
from fes.protocol import messages
from fes.protocol.messages import Beacon, Observation, Welcome
from field.runtime.fixes import Fix
from field.senses.senses import Senses


class Step(NamedTuple):
    """All that went into a tick, and all that came out of it."""

    observation: Observation
    heard: list[Beacon]
    """Beacons of the tick before, by sender."""
    beacon: bytes
    """Payload of the own beacon."""
    command: bytes
    """Payload of the own command."""


class Stepper:
    """A crew of one, and its senses."""

    def __init__(self, config: AgentConfig, robot: int, senses: Senses) -> None:
        self._crew = HostedCrew(Welcome((robot,), config))
        self._senses = senses

    def step(self, tick: int, fix: Fix, since: int) -> Step:
        """The step of `tick`, for a robot that takes part since the tick `since`.

        Raises FesError for a twist that is not finite.
        """
        observation, heard = self._senses.step(tick, fix.pose, fix.tick, since)
        [(_, beacon, command)] = self._crew.answer(self._crew.observe([observation]), heard)
        return Step(observation, heard, beacon, command)


def twist(step: Step) -> tuple[float, float]:
    """The twist of a step's command [m/s, rad/s]."""
    return messages.decode_command(step.command).twist
