"""The shell of an agent: joins, waits for a tick, gathers beacons, steps its crew, publishes."""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy: no thread pool for arrays this small

import argparse
import asyncio
import logging
import time
from pathlib import Path

import numpy as np

from agents.control import contacts, crew, transmitter
from agents.runtime import marshalling
from agents.runtime.beacon_subscriptions import BeaconSubscriptions
from agents.runtime.marshalling import MessageAssembler
from agents.runtime.membership import PATIENCE, Membership
from agents.runtime.outbox import Outbox
from agents.runtime.tick_source import TickSource
from fes import process
from fes.errors import FesError, Rejected, Unavailable
from fes.model.sensing import Observations
from fes.protocol import keys, messages
from fes.protocol.messages import Beacon, Welcome
from fes.system import output
from fes.transport import bus, identity
from fes.transport.bus import Bus
from fes.transport.drop_log import DropLog
from fes.transport.endpoints import Endpoints
from fes.transport.identity import Identity
from fes.transport.inbox import Inbox

AUTO = "auto"
"""Instead of an id: the lowest robot that is free."""


class Agent:
    """One process's part in a run: the robots it hosts, and their way to the bus."""

    def __init__(self, opened: Bus, run: str, robots: tuple[int, ...]) -> None:
        name = f"agent.{robots[0]}" if len(robots) == 1 else f"agent.{robots[0]}-{robots[-1]}"
        self.logger = logging.getLogger(name)
        self.complaints = DropLog(self.logger)
        self.radio = BeaconSubscriptions(opened, run, keys.span(robots), self.complaints)
        self._bus = opened
        self._run = run
        self._robots = robots
        self._inbox = Inbox(asyncio.get_running_loop())
        self.membership = Membership(opened, run, robots, self._inbox, lambda: self._turns.tick)
        self._mouth = Outbox(opened, run, robots, self.complaints, self.membership.join.mark)
        self._turns = TickSource(robots, self._inbox, self._mouth, self.complaints, self.membership.on_quiet)
        self._late = 0

    async def join(self, timeout: float) -> Welcome:
        """Wait for the world, and ask it for the robots; raises Absent or Refused."""
        return await self.membership.join_run(timeout)

    async def live(self, welcome: Welcome) -> None:
        """The robots' life: one step a tick, until the world says that the run is over."""
        ids = np.array(welcome.robots, dtype=np.int64)
        robots = crew.create(welcome.config, ids)
        state = crew.start(robots)
        stack = MessageAssembler(ids)
        for robot in self._robots:
            self._bus.declare_subscriber(keys.observation(self._run, robot), self._inbox.put)
        for robot in self._robots:  # last of all: a token says that everything above is in place
            self._bus.declare_token(keys.robot_alive(self._run, robot))
        self.logger.info("ready")
        world = self.membership.world
        tuned, since = None, np.zeros(len(ids), dtype=np.int64)
        lockstep = welcome.config.clock == "lockstep"
        async for received in self._turns.lockstep(world) if lockstep else self._turns.live(world):
            observations = stack.observations(received)
            now = np.array([message.since for message in received])
            if (now != since).any():  # they were away
                state, since = crew.forget(robots, state, now != since), now
            heard = self.radio.heard(observations.tick - 1)
            if lockstep:
                heard = await self._complete(observations, heard)
            else:  # a late beacon is lost
                self._late += contacts.missing(observations, [beacon.robot for beacon in heard])
            beacons = stack.beacons(observations.tick - 1, heard)
            state, said, twists = crew.step(robots, state, observations, beacons)
            if observations.in_range is not tuned:
                tuned = observations.in_range
                self.radio.update(set(tuned.peers.tolist()))
            spoken = list(marshalling.encode_tick(said, twists, crew.telemetry(robots, state)))
            self._mouth.publish(observations.tick, transmitter.on_air(robots.transmitters, observations.tick, spoken))
        self.membership.close()

    async def _complete(self, observations: Observations, heard: list[Beacon]) -> list[Beacon]:
        """All beacons that decoded, by sender; raises Absent if one is missing, since digits would change.

        Links are first-in first-out. So a beacon is missing only if junk filled a mailbox, if it took a slower path
        than the tick, or if a router died with it. A busy world is asked again for as long as it is there.
        """
        world = self.membership.world
        while absent := contacts.decoded(observations) - {beacon.robot for beacon in heard}:
            found, refused = await self.radio.recall(observations.tick - 1, sorted(absent))
            heard = sorted([*heard, *found], key=lambda beacon: beacon.robot)
            if len(found) == len(absent):
                break
            if not (await world.comes_back() if refused else await world.stays()):
                raise Unavailable(f"a beacon that decoded did not arrive at tick {observations.tick}")
        return heard

    def certified(self, endpoints: Endpoints, directory: Path) -> str:
        """What its certificate, with which the session opened, may have to do with a world that is absent."""
        who = Identity(directory, identity.robot_role(self._robots))
        try:
            who.check()  # it was good at the start
        except FesError as wrong:
            return str(wrong)
        if self.membership.world.was_seen or endpoints.mode != "client":
            return ""
        return f"{endpoints.shown} takes our certificate; a world there logs whether its run has no role '{who.role}'"

    @property
    def lag(self) -> str:
        """What the live clock did not wait for, in words; empty if nothing."""
        if self._late or self._turns.skipped:
            return f"{self._late} beacons came too late, {self._turns.skipped} ticks were skipped"
        return ""

    @property
    def overflow(self) -> int:
        """Messages that found no room to wait."""
        return self._inbox.dropped


async def lease(opened: Bus, run: str, timeout: float) -> int:
    """The lowest robot that nobody hosts, once there is one; raises Absent or Refused after `timeout` [s]."""
    end = time.monotonic() + timeout
    while True:
        left = end - time.monotonic()
        try:
            answer = await opened.get(keys.lease(run), b"", max(left, PATIENCE))
        except (Unavailable, Rejected) as error:
            if left <= PATIENCE:
                never = Unavailable(f"no world of run '{run}' leases robots here (asked for {timeout:g} s)")
                raise error if isinstance(error, Rejected) else never from None
            await asyncio.sleep(PATIENCE)  # a world may come, or a robot be left by its agent
        else:
            return messages.decode_lease(answer)


async def serve(flags: argparse.Namespace) -> int:
    """One agent process, from start to exit code."""
    run = keys.check_run(flags.run)
    robots = keys.parse_span(flags.id, "--id", "I, A-B or auto") if flags.id != AUTO else (0,)
    if flags.id == AUTO and flags.keys:
        raise FesError("--id auto does not go with --keys: a certificate is for one robot")
    endpoints = process.agent_endpoints(flags, flags.timeout, identity.robot_role(robots))
    logging.getLogger(f"agent.{flags.id}").info("waiting for the world at %s, run '%s'", endpoints.shown, run)
    async with bus.opened(endpoints) as opened:
        if flags.id == AUTO:
            robots = (await lease(opened, run, flags.timeout),)
        agent = Agent(opened, run, robots)
        try:
            welcome = await agent.join(flags.timeout)
            await agent.live(welcome)
            agent.logger.info("the run is over")
        except Unavailable as absent:
            if flags.keys and (why := agent.certified(endpoints, flags.keys)):
                raise Unavailable(f"{absent}: {why}") from None
            raise
        finally:
            agent.complaints.log_total(agent.overflow)
            if agent.lag:
                agent.logger.info("%s", agent.lag)
    return process.SUCCESS


def main() -> None:
    """Entry point of fes-agent."""
    output.configure()
    parser = process.OneLineParser(
        prog="fes-agent", description="One robot, or a range of robots, of a run.", epilog="example: fes-agent --id 0"
    )
    parser.add_argument("--id", required=True, metavar="I|A-B|auto", help="the robot, a range, or any that is free")
    parser.add_argument(
        "--timeout",
        type=process.seconds,
        default=30.0,
        metavar="S",
        help="give up if the world is not there by then, at first or when it has left (default: %(default)g s)",
    )
    process.add_network_flags(parser)
    flags = parser.parse_args()
    process.run("fes-agent", lambda: serve(flags), exit_with_stdin=flags.exit_with_stdin)


if __name__ == "__main__":
    main()
