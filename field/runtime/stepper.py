"""One tick of a real robot: from its fix and what its radio has heard to its beacon and its command."""

from typing import NamedTuple

from agents.runtime.hosted_crew import HostedCrew
from fes.model.config import AgentConfig
from fes.protocol import messages
from fes.protocol.messages import Beacon, Observation, Welcome
from fes.protocol.sealed import Sealed
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


def warm_up(config: AgentConfig, robot: int) -> None:
    """Step another crew with these settings and a peer, so that all code is loaded before the robot moves.

    A first step takes as long as hundreds of others. Meanwhile no beacon leaves, and every peer conceals the pause at
    the start of a run, which distorts the first estimates. Raises FesError for settings that no crew accepts.
    """
    peer, senses = robot + 1, Senses(robot, 4)
    own, far = Stepper(config, robot, senses), Stepper(config, peer, Senses(peer, 4))
    for tick in range(1, 5):
        twist(own.step(tick, Fix((0.0, 0.0, 0.0), tick), 1))
        beacon = messages.decode_beacon(far.step(tick, Fix((60.0, 1.0, 0.0), tick), 1).beacon)
        senses.hear(Sealed(peer, 1, tick, b""), beacon, tick + 0.5)


def twist(step: Step) -> tuple[float, float]:
    """The twist of a step's command [m/s, rad/s]."""
    return messages.decode_command(step.command).twist
