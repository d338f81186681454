"""The agent process: joins a run, then collects beacons, steps its crew and publishes at each tick."""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy: no thread pool for arrays this small
os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")  # else pydantic reads the metadata of all distributions

import argparse
import asyncio
import logging
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import TypeVar

from agents.runtime import reception
from agents.runtime.beacon_subscriptions import BeaconSubscriptions
from agents.runtime.hosted_crew import HostedCrew
from agents.runtime.membership import PATIENCE, Membership
from agents.runtime.outbox import Outbox
from agents.runtime.tick_source import TickSource
from fes import command_line, process
from fes.arrays.edges import Edges
from fes.errors import FesError, Rejected, Unavailable
from fes.model.sensing import Observations
from fes.protocol import keys, messages
from fes.protocol.messages import Beacon, Observation, Welcome
from fes.system import output
from fes.transport import bus, identity
from fes.transport.bus import Bus
from fes.transport.drop_log import DropLog
from fes.transport.endpoints import Endpoints
from fes.transport.identity import Identity
from fes.transport.inbox import ThreadInbox

T = TypeVar("T")

AUTO = "auto"
"""Value of --id that stands for the lowest free robot."""


class Agent:
    """One process in a run: the robots that it hosts, and their connection to the bus."""

    def __init__(self, opened: Bus, run: str, robots: tuple[int, ...]) -> None:
        name = f"agent.{robots[0]}" if len(robots) == 1 else f"agent.{robots[0]}-{robots[-1]}"
        self.logger = logging.getLogger(name)
        self.drops = DropLog(self.logger)
        self.radio = BeaconSubscriptions(opened, run, keys.span(robots), self.drops)
        self._bus = opened
        self._run = run
        self._robots = robots
        self._inbox = ThreadInbox()
        self.membership = Membership(opened, run, robots, self._inbox, lambda: self._ticks.tick)
        self._outbox = Outbox(opened, run, robots, self.drops, self.membership.join.mark)
        self._ticks = TickSource(run, robots, self._inbox, self._outbox, self.drops, self._on_quiet)
        self._loop = asyncio.get_running_loop()
        self._subscribed: Edges | frozenset[int] | None = None
        """The pairs or peers in range for which the beacon subscriptions are declared."""
        self._late = 0

    async def join(self, timeout: float) -> Welcome:
        """Wait for the world up to `timeout` [s], and request the robots; raises Unavailable or Rejected."""
        return await self.membership.join_run(timeout)

    async def live(self, welcome: Welcome) -> None:
        """Step the crew at each tick, until the world ends the run; raises Unavailable or Rejected."""
        crew = HostedCrew(welcome)
        for robot in self._robots:
            self._bus.declare_subscriber(keys.observation(self._run, robot), self._inbox.put)
        for robot in self._robots:  # last: a token promises that all subscriptions are declared
            self._bus.declare_token(keys.robot_alive(self._run, robot))
        self.logger.info("ready")
        lockstep, world = welcome.config.clock == "lockstep", self.membership.world
        answer = partial(self._answer_bytes, crew)
        ticks = self._ticks.lockstep(world, answer) if lockstep else self._ticks.live(world)
        with ThreadPoolExecutor(1, "ticks") as thread:
            while incomplete := await self._in(thread, partial(self._answer, crew, ticks, lockstep)):
                observations, heard = incomplete
                self._publish(crew, observations, await self._complete(observations, heard))
        self.membership.close()

    def _on_quiet(self) -> None:
        """Confirm the membership after a silence; called in the thread of the ticks."""
        self._loop.call_soon_threadsafe(self.membership.on_quiet)

    async def _in(self, thread: ThreadPoolExecutor, work: Callable[[], T]) -> T:
        """The result of `work` in a thread, which ends first if this task is cancelled: the inbox closes."""
        running = self._loop.run_in_executor(thread, work)
        try:
            return await asyncio.shield(running)
        except asyncio.CancelledError:
            self._inbox.close(Unavailable("the agent is stopped"))
            await asyncio.gather(running, return_exceptions=True)
            raise

    def _answer(
        self, crew: HostedCrew, ticks: Iterator[list[Observation]], lockstep: bool
    ) -> tuple[Observations, list[Beacon]] | None:
        """Answer tick after tick, until the run is over, or a beacon is missing: only the loop can recall it.

        Runs in a thread of its own, which wakes at a lower cost than the loop. Returns None, or the
        observations of the tick that is not answered yet, and the beacons that have arrived for it.
        """
        for received in ticks:
            observations = crew.observe(received)
            heard = self.radio.heard(observations.tick - 1)
            senders = [beacon.robot for beacon in heard]
            if not lockstep:  # the live clock does not wait for late beacons
                self._late += reception.missing(observations, senders)
            elif reception.absent(observations, senders):
                return observations, heard
            self._publish(crew, observations, heard)
        return None

    def _answer_bytes(self, crew: HostedCrew, tick: int, observations: list[bytes]) -> bool:
        """Answer a tick in one call of the compiled core; False if a message is unusual, and nothing was done."""
        if not crew.is_compiled:
            return False
        beacons = self.radio.payloads(tick - 1)
        payloads = crew.answer_bytes(tick, observations, beacons)
        if payloads is None:
            return False
        self.radio.use(beacons)
        if crew.peers is not self._subscribed:
            self._subscribed = crew.peers
            self.radio.update(crew.peers)
        self._outbox.publish(tick, payloads)
        return True

    def _publish(self, crew: HostedCrew, observations: Observations, heard: list[Beacon]) -> None:
        """Step the crew, subscribe to the peers that are now in range, and publish beacons and commands."""
        payloads = crew.answer(observations, heard)
        if observations.in_range is not self._subscribed:
            self._subscribed = observations.in_range
            self.radio.update(observations.in_range.peer_set)
        self._outbox.publish(observations.tick, payloads)

    async def _complete(self, observations: Observations, heard: list[Beacon]) -> list[Beacon]:
        """All beacons that decoded, ordered by sender. Raises Unavailable if one stays missing: digits would change.

        Network connections are first-in first-out. A beacon is missing only if junk filled a mailbox, it took a
        slower path than the tick, or a router died with it. A busy world is asked again while it is reachable.
        """
        world = self.membership.world
        while absent := reception.absent(observations, [beacon.robot for beacon in heard]):
            recalled, rejected = await self.radio.recall(observations.tick - 1, absent)
            heard = sorted([*heard, *recalled], key=lambda beacon: beacon.robot)
            if len(recalled) == len(absent):
                break
            if not (await world.should_retry_rejected() if rejected else await world.should_retry()):
                raise Unavailable(f"a beacon that decoded did not arrive at tick {observations.tick}")
        return heard

    def certificate_reason(self, endpoints: Endpoints, directory: Path) -> str:
        """Reason why this agent's certificate may hide the world from it, in words; empty without one."""
        own = Identity(directory, identity.robot_role(self._robots))
        try:
            own.check()  # it was valid when the session opened
        except FesError as error:
            return str(error)
        if self.membership.world.was_seen or endpoints.mode != "client":
            return ""
        return (
            f"{endpoints.shown} accepts our certificate; a world there logs whether its run has no role '{own.role}'"
        )

    @property
    def lag(self) -> str:
        """Numbers of late beacons and skipped ticks of the live clock, in words; empty without any."""
        if self._late or self._ticks.skipped:
            return f"{self._late} beacons came too late, {self._ticks.skipped} ticks were skipped"
        return ""

    @property
    def overflow(self) -> int:
        """Number of messages dropped from a full inbox."""
        return self._inbox.dropped


async def lease(opened: Bus, run: str, timeout: float) -> int:
    """The lowest robot without an agent, when one is free. Raises Unavailable or Rejected after `timeout` [s]."""
    end = time.monotonic() + timeout
    while True:
        left = end - time.monotonic()
        try:
            answer = await opened.get(keys.lease(run), b"", max(left, PATIENCE))
        except (Unavailable, Rejected) as error:
            if left <= PATIENCE:
                absent = Unavailable(f"no world of run '{run}' leases robots here (asked for {timeout:g} s)")
                raise error if isinstance(error, Rejected) else absent from None
            await asyncio.sleep(PATIENCE)  # meanwhile a world may start, or an agent may leave its robot
        else:
            return messages.decode_lease(answer)


async def serve(flags: argparse.Namespace) -> int:
    """Run one agent process, and return its exit code."""
    run = keys.check_run(flags.run)
    robots = keys.parse_span(flags.id, "--id", "I, A-B or auto") if flags.id != AUTO else (0,)
    if flags.id == AUTO and flags.keys:
        raise FesError("--id auto does not go with --keys: a certificate is for one robot")
    endpoints = command_line.agent_endpoints(flags, flags.timeout, identity.robot_role(robots))
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
            if flags.keys and (why := agent.certificate_reason(endpoints, flags.keys)):
                raise Unavailable(f"{absent}: {why}") from None
            raise
        finally:
            agent.drops.log_total(agent.overflow)
            if agent.lag:
                agent.logger.info("%s", agent.lag)
    return process.SUCCESS


def main() -> None:
    """Entry point of fes-agent."""
    output.configure()
    parser = command_line.OneLineParser(
        prog="fes-agent", description="One robot, or a range of robots, of a run.", epilog="example: fes-agent --id 0"
    )
    parser.add_argument("--id", required=True, metavar="I|A-B|auto", help="one robot, a range, or any free robot")
    parser.add_argument(
        "--timeout",
        type=command_line.seconds,
        default=30.0,
        metavar="S",
        help="longest wait for the world, at the start and whenever it is absent (default: %(default)g s)",
    )
    command_line.add_use_flag(parser)
    command_line.add_network_flags(parser)
    flags = parser.parse_args()
    process.run("fes-agent", lambda: serve(flags), exit_with_stdin=flags.exit_with_stdin)


if __name__ == "__main__":
    main()
