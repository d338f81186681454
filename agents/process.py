"""The shell of an agent: joins, waits for a tick, gathers beacons, steps its crew, publishes."""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy: no thread pool for arrays this small

import argparse
import asyncio
import logging
import re
import secrets
import time
from pathlib import Path

import numpy as np

from agents import assembly, contacts, crew, transmitter
from agents.assembly import Assembly
from agents.mouth import Mouth
from agents.presence import Presence
from agents.radio import Radio
from agents.turns import Turns
from fes import bus, identity, keys, messages, output, process
from fes.bus import Bus
from fes.complaints import Complaints
from fes.endpoints import Endpoints
from fes.errors import Absent, Busy, FesError, MessageError, Refused
from fes.identity import Identity
from fes.inbox import Inbox
from fes.keys import MAX_ROBOTS
from fes.messages import MAX_AGENT, Join, Welcome

_NUMBER = re.compile("[0-9]{1,9}")

AUTO = "auto"
"""Instead of an id: the lowest robot that is free."""

ANSWER_TIMEOUT = 5.0
"""A world that is there and does not answer a join for so long [s] is asked again."""

CONFIRMATIONS = 10
"""An agent that was not seen for a while asks so many times whether it is welcome still."""

PATIENCE = 1.0
"""How long [s] an agent waits before it asks again, without an id, or where too many ask at once: then at most."""


class Agent:
    """One process's part in a run: the robots it hosts, and their way to the bus."""

    def __init__(self, opened: Bus, run: str, robots: tuple[int, ...]) -> None:
        name = f"agent.{robots[0]}" if len(robots) == 1 else f"agent.{robots[0]}-{robots[-1]}"
        self.logger = logging.getLogger(name)
        self.complaints = Complaints(self.logger)
        self.radio = Radio(opened, run, self.complaints)
        self._bus = opened
        self._run = run
        self._robots = robots
        self._welcome = keys.welcome(run, keys.span(robots))
        self._join = messages.encode_join(Join(robots, secrets.randbelow(MAX_AGENT)))
        self._welcomed = b""
        self._confirming: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self._inbox = Inbox(asyncio.get_running_loop())
        self._world = Presence(f"the world of run '{run}'", self._inbox)
        self._mouth = Mouth(opened, run, robots, self.complaints)
        self._turns = Turns(robots, self._inbox, self._mouth, self.complaints)
        self._late = 0

    async def join(self, timeout: float) -> Welcome:
        """Wait for the world, and ask it for the robots; raises Absent or Refused."""
        self._bus.watch(keys.world_alive(self._run), self._on_world)
        self._world.patience = timeout
        end = time.monotonic() + timeout
        while True:
            await self._world.appears(max(0.0, end - time.monotonic()))
            try:
                answer = await self._bus.ask(self._welcome, self._join, ANSWER_TIMEOUT)
                break
            except (Absent, Busy):  # it may just have left; or all agents of a large team ask at once
                if time.monotonic() > end:
                    raise
                await asyncio.sleep(PATIENCE * (1 + self._robots[0] % 10) / 10)  # not all at once again
        welcome, self._welcomed = messages.decode_welcome(answer), answer
        if welcome.robots != self._robots:
            raise MessageError("Welcome", "is for other robots than asked for", str(welcome.robots[:5]))
        return welcome

    async def live(self, welcome: Welcome) -> None:
        """The robots' life: one step a tick, until the world says that the run is over."""
        ids = np.array(welcome.robots, dtype=np.int64)
        robots = crew.assemble(welcome.config, ids)
        state = crew.start(robots)
        stack = Assembly(ids)
        for robot in self._robots:
            self._bus.subscribe(keys.observation(self._run, robot), self._inbox.put)
        for robot in self._robots:  # last of all: a token says that everything above is in place
            self._bus.token(keys.robot_alive(self._run, robot))
        self.logger.info("ready")
        tuned, since = None, np.zeros(len(ids), dtype=np.int64)
        lockstep = welcome.config.clock == "lockstep"
        async for received in self._turns.lockstep(self._world) if lockstep else self._turns.live(self._world):
            observations = stack.observations(received)
            now = np.array([message.since for message in received])
            if (now != since).any():  # they were away
                state, since = crew.forget(robots, state, now != since), now
            heard = self.radio.heard(observations.tick - 1)
            stepped = crew.step(robots, state, observations, stack.beacons(observations.tick - 1, heard))
            while not contacts.all_here(stepped[0].contacts, observations):
                if not lockstep:  # what comes late is lost
                    self._late += contacts.missing(stepped[0].contacts, observations)
                    break
                # Links are first-in first-out and pass one router: this can be only where a mailbox was flooded, or
                # the router died with the beacon.
                heard = await self.radio.recall(observations.tick - 1, heard)
                stepped = crew.step(robots, state, observations, stack.beacons(observations.tick - 1, heard))
                if not contacts.all_here(stepped[0].contacts, observations) and not await self._world.comes_back():
                    # To go on would change digits.
                    raise Absent(f"a beacon that decoded did not arrive at tick {observations.tick}")
            state, said, twists = stepped
            if observations.in_range is not tuned:
                tuned = observations.in_range
                self.radio.tune(set(tuned.peers.tolist()))
            spoken = list(assembly.payloads(said, twists, crew.telemetry(robots, state)))
            self._mouth.say(observations.tick, transmitter.on_air(robots.transmitters, observations.tick, spoken))
        self._confirming.cancel()

    def _on_world(self, key: str, alive: bool) -> None:
        self._world.told(alive, self._turns.tick)
        if self._world.is_new and alive:
            self._confirming.cancel()
            self._confirming = asyncio.ensure_future(self._confirm())

    async def _confirm(self) -> None:
        """Ask a world that is back whether it still wants this agent: its robots may have got another one meanwhile.

        For it may be this agent that was away, for longer than its token stood.
        """
        for _ in range(CONFIRMATIONS):
            try:
                answer = await self._bus.ask(self._welcome, self._join, ANSWER_TIMEOUT)
                if self._welcomed not in (b"", answer):
                    self._inbox.fail(Refused("another run has taken the place of this one"))
                return
            except (Absent, Busy):
                await asyncio.sleep(PATIENCE * (1.0 + self._robots[0] % 10 / 10))
            except Refused as refused:
                self._inbox.fail(refused)
                return
        self.logger.warning("the world is back, and does not say whether it still wants this agent")

    def certified(self, endpoints: Endpoints, directory: Path) -> str:
        """What its certificate, with which the session opened, may have to do with a world that is absent."""
        who = Identity(directory, identity.robot_role(self._robots))
        try:
            who.check()  # it was good at the start
        except FesError as wrong:
            return str(wrong)
        if self._world.was_seen or endpoints.mode != "client":
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
            answer = await opened.ask(keys.lease(run), b"", max(left, PATIENCE))
        except (Absent, Refused) as error:
            if left <= PATIENCE:
                never = Absent(f"no world of run '{run}' leases robots here (asked for {timeout:g} s)")
                raise error if isinstance(error, Refused) else never from None
            await asyncio.sleep(PATIENCE)  # a world may come, or a robot be left by its agent
        else:
            return messages.decode_lease(answer)


async def serve(flags: argparse.Namespace) -> int:
    """One agent process, from start to exit code."""
    run = keys.check_run(flags.run)
    robots = parse_ids(flags.id) if flags.id != AUTO else (0,)
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
        except Absent as absent:
            if flags.keys and (why := agent.certified(endpoints, flags.keys)):
                raise Absent(f"{absent}: {why}") from None
            raise
        finally:
            agent.complaints.log_total(agent.overflow)
            if agent.lag:
                agent.logger.info("%s", agent.lag)
    return process.SUCCESS


def parse_ids(text: str) -> tuple[int, ...]:
    """Robot ids from `--id I` or `--id A-B`; raises FesError.

    >>> parse_ids("3"), parse_ids("2-4")
    ((3,), (2, 3, 4))
    """
    first, dash, last = text.partition("-")
    if not _NUMBER.fullmatch(first) or (dash and not _NUMBER.fullmatch(last)):
        raise FesError(f"--id expects I, A-B or auto with integers from 0, got '{text[:40]}'")
    low, high = int(first), int(last) if dash else int(first)
    if high < low or high >= MAX_ROBOTS:
        raise FesError(f"--id expects I or A-B with A <= B < {MAX_ROBOTS}, got '{text}'")
    return tuple(range(low, high + 1))


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
