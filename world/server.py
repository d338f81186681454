"""The lockstep over the bus: observations out, commands in, one barrier a tick."""

import asyncio
import logging
import time
from dataclasses import replace
from typing import Any

import numpy as np

from fes import keys, messages, wire
from fes.arrays import Floats
from fes.bus import Bus, Question
from fes.change import Effect, decode_change, encode_effect
from fes.complaints import Complaints
from fes.edges import Stack
from fes.errors import Absent, MessageError, ScenarioError
from fes.inbox import Inbox
from fes.messages import Command, Observation
from fes.report import encode_report
from fes.sensing import Observations, Telemetry, untold
from world import events, reporting, simulation, summary
from world.account import Account
from world.optimum import optimal_separation
from world.roster import Roster
from world.scenario import Scenario, agent_config, with_event
from world.simulation import State

ANSWER_TIMEOUT = 10.0
"""A living robot that does not answer a tick for this long [s] is hung: its liveliness token would stay."""

ASK_AGAIN = 0.5
"""An observation is sent again to robots that did not answer it for this long [s], then for twice as long, ..."""


class Server:
    """One run of one scenario."""

    def __init__(self, bus: Bus, scenario: Scenario, name: str, run: str, rtf: float | None) -> None:
        self.scenario = scenario
        self.name = name
        self.logger = logging.getLogger("world")
        self.complaints = Complaints(self.logger)
        robots = range(scenario.robots.number)
        self._rtf = rtf
        self._world = simulation.create(scenario)
        self._state = simulation.start(self._world)
        self._sums = Account(scenario)
        self._stack = Stack()
        self._said = untold(self._world.ids)
        self._inbox = Inbox(asyncio.get_running_loop())
        self._observe = [bus.publisher(keys.observation(run, robot), "fes.Observation") for robot in robots]
        self._report = bus.publisher(keys.report(run), "fes.Report", drop=True)
        self._robot_of = {keys.command(run, robot): robot for robot in robots}
        bus.subscribe(keys.command(run, "*"), self._inbox.put)
        self._roster = Roster(bus, run, len(robots), agent_config(scenario), self.complaints)
        bus.serve(keys.change(run), self._on_change)
        bus.token(keys.world_alive(run))  # last: it says that everything above is in place
        self._unaccounted: tuple[State, Floats] | None = None
        self._asked: dict[int, int] = {}  # the last tick that each robot was asked for again
        self._begun = self._told_at = self._ended = 0.0
        self._told_tick = 0

    async def gather(self) -> None:
        """Wait until every robot is here."""
        self.logger.info("waiting for %d robots", len(self._observe))
        while not self._roster.alive.all():
            await self._roster.complete.wait()
        self._roster.report_losses_to(self._on_loss)
        self.logger.info("all robots are here: %s starts", self.name)

    async def run(self) -> None:
        """All ticks of the scenario; ends early, with what was reached, if it is cancelled."""
        self._begun = self._told_at = time.perf_counter()
        while self._state.tick < self.scenario.ticks:
            sent = self._publish(simulation.observe(self._state))
            self._account()  # for the last tick, while the robots think about this one
            twists = self._tell_apart(await self._barrier(sent))
            self._unaccounted = self._state, twists
            self._state = simulation.step(self._world, self._state, twists)
            await self._pace()
        self._account()
        self._ended = time.perf_counter()

    def summarize(self) -> dict[str, Any] | None:
        """The summary of the ticks that were run; None before the first."""
        self._account()
        if self._sums.tally.ticks == 0:
            return None
        wall = (self._ended or time.perf_counter()) - self._begun
        return summary.summarize(self._sums, self.name, "processes", wall)

    @property
    def overflow(self) -> int:
        """Messages that found no room to wait."""
        return self._inbox.dropped

    def dismiss(self) -> None:
        """Tell every robot and observer that the run is over."""
        self._account()
        if self._sums.tally.ticks:
            self._tell()
        nothing = np.zeros(0, dtype=np.int64)
        for robot, (put, pose) in enumerate(zip(self._observe, self._state.poses.tolist(), strict=True)):
            farewell = Observation(self._state.tick, robot, tuple(pose), nothing, nothing.astype(np.uint8), over=True)
            put(messages.encode_observation(farewell))

    def _on_change(self, question: Question) -> None:
        """Somebody wants the channel to be another one; it is from the tick that goes on, beacons of it included."""
        try:
            change = decode_change(question.payload)
            changed = events.changed(self._state.channel, {change.path: change.value}, self.scenario.run.dt)
        except (MessageError, ScenarioError) as error:
            self.complaints.add("Change: refused", f"a change: {error}")
            question.refuse(str(error))
            return
        tick = self._state.tick
        if tick >= self.scenario.ticks:
            question.refuse("the run is over")
            return
        self._state = replace(self._state, channel=changed)
        value = events.effective(changed, change.path)
        self.scenario = with_event(self.scenario, tick, change.path, value)
        optimal = optimal_separation(self.scenario.objective, changed)
        self.logger.info("tick %d: %s = %s, r* = %.3f m", tick, change.path, value, optimal)
        question.answer(encode_effect(Effect(change.path, value, tick, optimal)), "fes.Effect")

    def _on_loss(self, robot: int) -> None:
        self._inbox.fail(
            Absent(
                f"robot {robot} left at tick {self._state.tick}: its agent died, was stopped or lost its connection"
            )
        )

    def _account(self) -> None:
        """Add the last tick to the tally, and report to observers if it is time."""
        if self._unaccounted is None:
            return
        state, twists = self._unaccounted
        self._unaccounted = None
        self._sums.add(state, twists, self._said)
        if time.perf_counter() - self._told_at >= reporting.PERIOD:
            self._tell()

    def _publish(self, observations: Observations) -> list[bytes]:
        """Put each robot's observation; returns the payloads, to be sent again if need be."""
        spans, sent = observations.in_range.spans, []
        for robot, (pose, span) in enumerate(zip(observations.poses.tolist(), spans, strict=True)):
            message = Observation(
                observations.tick,
                robot,
                tuple(pose),
                observations.in_range.peers[span],
                observations.reception[span],
                over=False,
            )
            payload = messages.encode_observation(message)
            self._observe[robot](payload)
            sent.append(payload)
        return sent

    async def _barrier(self, sent: list[bytes]) -> list[Command]:
        """The command of every robot for this tick, in id order; raises Absent for one that does not answer."""
        answers: list[Command | None] = [None] * len(sent)
        missing, begun, patience = len(sent), time.monotonic(), ASK_AGAIN
        ask_at = begun + patience
        while missing:
            # Messages are only counted here, so junk may wake us too: time is looked at on every pass.
            await self._inbox.wait(missing, max(0.0, ask_at - time.monotonic()))
            for key, payload in self._inbox.drain():
                command = self._read(key, payload)
                if command is not None and answers[command.robot] is None:
                    answers[command.robot] = command
                    missing -= 1
                elif command is not None and self._asked.get(command.robot) != command.tick:
                    self.complaints.add("Command: came twice", f"{key}: a second command for tick {command.tick}")
            if missing and time.monotonic() >= ask_at:
                silent = [robot for robot, answer in enumerate(answers) if answer is None]
                if time.monotonic() - begun >= ANSWER_TIMEOUT:
                    raise Absent(f"robot {silent[0]} did not answer tick {self._state.tick} for {ANSWER_TIMEOUT:g} s")
                for robot in silent:
                    self._observe[robot](sent[robot])
                    self._asked[robot] = self._state.tick
                patience *= 2.0
                ask_at = min(time.monotonic() + patience, begun + ANSWER_TIMEOUT)
        return [answer for answer in answers if answer is not None]

    def _read(self, key: str, payload: bytes | None) -> Command | None:
        """The command in a message if it is one for this tick; anything else is dropped and counted.

        A second answer to the last tick is no fault: its robot was asked again just when it answered.
        """
        robots = len(self._observe)
        try:
            if payload is None:
                raise MessageError("Command", "a deletion is not a command")
            command = messages.decode_command(payload)
            if self._robot_of.get(key) != command.robot:
                raise MessageError("Command", "came on another robot's key", key)
            if command.tick == self._state.tick - 1 == self._asked.get(command.robot):
                return None
            if command.tick != self._state.tick:
                raise MessageError("Command", "is not for this tick", str(command.tick))
            if len(command.links) and command.links[-1] >= robots:
                raise MessageError("Command", "has a link to a robot that does not exist", str(command.links[-1]))
        except MessageError as error:
            self.complaints.add(f"{error.schema}: {error.rule}", f"{key}: {error}")
            return None
        return command

    def _tell_apart(self, commands: list[Command]) -> Floats:
        """The twists [n, 2] in the commands; the telemetry beside them is kept for the tally and the report."""
        links = self._stack.edges(self._world.ids, [command.links for command in commands])
        estimates = np.concatenate([command.estimates for command in commands])
        learnt = np.zeros((2, 0))
        if len(estimates) and all(len(command.learnt) == 2 * len(command.links) for command in commands):
            learnt = np.concatenate([command.learnt.reshape(2, -1) for command in commands], axis=1)
        self._said = Telemetry(links, estimates, learnt)
        return np.array([command.twist for command in commands])

    def _tell(self) -> None:
        now = time.perf_counter()
        ticks = self._sums.tally.ticks
        rate = (ticks - self._told_tick) / max(now - self._told_at, 1e-9)
        self._told_at, self._told_tick = now, ticks
        report = reporting.build(self._sums, self.name, self._roster.alive, now - self._begun, rate)
        payload = encode_report(report)
        if len(payload) <= wire.MAX_PAYLOAD:  # beyond, at about 8,000 robots, there is nothing to watch
            self._report(payload)

    async def _pace(self) -> None:
        """With a real-time factor, wait until this tick is due. Falling behind slows time; no tick is skipped."""
        if self._rtf is not None:
            due = self._begun + self._state.tick * self.scenario.run.dt / self._rtf
            ahead = due - time.perf_counter()
            if ahead > 0:
                await asyncio.sleep(ahead)
