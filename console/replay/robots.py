"""Some robots of a log, executed again by their own code."""

from collections.abc import Collection
from contextlib import suppress

import numpy as np

from agents.control import crew, transmitter
from agents.runtime import marshalling as agent_marshalling
from agents.runtime import reception
from agents.runtime.crew_run import CrewRun
from agents.runtime.marshalling import MessageAssembler
from console.replay.difference import of_payloads
from console.replay.log import Log
from console.replay.recorded import Mismatch, decoded
from fes.errors import FesError, MessageError
from fes.protocol import messages
from fes.protocol.messages import Observation
from fes.recording.ticks import LoggedTick
from world.config.scenario import agent_config


class ReplayedRobots:
    """Some robots of a log, executed again tick by tick by their own code."""

    def __init__(self, log: Log, ids: Collection[int]) -> None:
        if log.scenario.run.clock == "live":
            raise FesError(
                f"{log.path} is of the live clock: the log does not show which inputs a robot received in time"
            )
        robots = np.array(sorted(ids), dtype=np.int64)
        self._crew = CrewRun(crew.create(agent_config(log.scenario), robots))
        self._stack = MessageAssembler(robots)
        self._robots = robots.tolist()
        self._log = log
        self._before: LoggedTick | None = None

    def step(self, tick: LoggedTick) -> None:
        """Execute a tick, and compare each Beacon and Command; raises Mismatch, or FesError for an incomplete log."""
        sensing = [robot for robot in self._robots if tick.payloads.observations[robot]]
        sensed = dict(
            zip(sensing, decoded(tick, messages.decode_observation, tick.payloads.observations, sensing), strict=True)
        )
        restarted = np.array([robot in sensed and sensed[robot].since == tick.number for robot in self._robots])
        if restarted.any():
            self._crew.forget(restarted)
        observations = self._stack.observations(
            [sensed.get(robot) or _absent(tick.number, robot) for robot in self._robots]
        )
        received = []
        if self._before is not None:
            payloads = self._before.payloads.beacons
            peers = [peer for peer in np.unique(observations.in_range.peers).tolist() if payloads[peer]]
            received = decoded(self._before, messages.decode_beacon, payloads, peers)
        if reception.missing(observations, [beacon.robot for beacon in received]):
            raise FesError(f"tick {tick.number - 1}: a Beacon that was decoded is not in the log")
        beacons = self._stack.beacons(tick.number - 1, received)
        sent, twists, telemetry = self._crew.step(observations, beacons)
        telemetry = telemetry._replace(is_model_free=stated([tick.payloads.commands[robot] for robot in sensing]))
        broken = transmitter.damaging(self._crew.crew.transmitters, tick.number)
        for robot, encoded, command in agent_marshalling.encode_tick(sent, twists, telemetry):
            if robot not in sensed:
                continue
            beacon = b"" if robot in broken else encoded
            recorded = tick.payloads.beacons[robot], tick.payloads.commands[robot]
            for message, logged, computed in zip(("Beacon", "Command"), recorded, (beacon, command), strict=True):
                if logged != computed:
                    raise Mismatch(self._log, of_payloads(tick.number, message, robot, logged, computed))
        self._before = tick


def stated(commands: list[bytes]) -> bool | None:
    """`is_model_free` of the recorded commands: a second execution cannot compute it."""
    for payload in filter(None, commands):
        with suppress(MessageError):
            return messages.decode_command(payload).is_model_free
    return None


def _absent(tick: int, robot: int) -> Observation:
    """Observation for an absent robot; its state is discarded when the robot rejoins."""
    nothing = np.zeros(0, dtype=np.int64)
    return Observation(tick, robot, (0.0, 0.0, 0.0), nothing, nothing.astype(np.uint8), over=False, since=0)
