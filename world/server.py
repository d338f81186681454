"""The lockstep over the bus: observations out, commands in, one barrier a tick."""

import asyncio
import logging
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from fes import keys, wire
from fes.arrays import Bools, Floats
from fes.bus import Bus, Question
from fes.change import Effect, decode_change, encode_effect
from fes.complaints import Complaints
from fes.errors import MessageError, ScenarioError
from fes.inbox import Inbox
from fes.messages import Command
from fes.report import encode_report
from fes.sensing import Observations, untold
from world import events, reporting, simulation, summary, wording
from world.account import Account
from world.attendance import Attendance
from world.ears import Ears
from world.optimum import optimal_separation
from world.recorder import Recorder, Said
from world.roster import Roster
from world.scenario import Scenario, agent_config, with_event
from world.simulation import State
from world.wording import Told

ANSWER_TIMEOUT = 10.0
"""A living robot that does not answer a tick for this long [s] is hung, for its liveliness token may stay: it is left
out until it speaks again."""

ASK_AGAIN = 0.5
"""An observation is sent again to robots that did not answer it for this long [s], then for twice as long, ..."""


class Server:
    """One run of one scenario."""

    def __init__(
        self,
        bus: Bus,
        scenario: Scenario,
        name: str,
        run: str,
        rtf: float | None,
        recorder: Recorder | None = None,
    ) -> None:
        self.scenario, self.name = scenario, name
        self.logger = logging.getLogger("world")
        self.complaints = Complaints(self.logger)
        robots = range(scenario.robots.number)
        self._rtf = rtf
        self.keep: Callable[[Scenario], None] = lambda scenario: None
        """Called with the scenario whenever a person has changed it."""
        self._world = simulation.create(scenario)
        self._state = simulation.start(self._world)
        self._sums = Account(scenario)
        self._told, self._said = Told(self._world.ids), untold(self._world.ids)
        self._recorder = recorder
        self._ears = Ears(bus, run, len(robots), self.complaints) if recorder is not None else None
        self._inbox = Inbox(asyncio.get_running_loop())
        self._observe = [bus.publisher(keys.observation(run, robot), "fes.Observation") for robot in robots]
        self._report = bus.publisher(keys.report(run), "fes.Report", drop=True)
        bus.subscribe(keys.command(run, "*"), self._inbox.put)
        self._roster = Roster(bus, run, len(robots), agent_config(scenario), self.complaints)
        bus.serve(keys.change(run), self._on_change)
        bus.token(keys.world_alive(run))  # last: it says that everything above is in place
        self._attendance = Attendance(self._roster, scenario)
        self._unaccounted: tuple[State, Floats, list[bytes], list[bytes]] | None = None
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
            self._attend(await self._attendance.assemble(self._state))
            sent = self._publish(simulation.observe(self._state))
            self._account()  # for the last tick, while the robots think about this one
            answers = await self._barrier(sent)
            twists, self._said = self._told.read([answer and answer[0] for answer in answers])
            commands = [answer[1] if answer else b"" for answer in answers]
            sent = [payload if answer else b"" for payload, answer in zip(sent, answers, strict=True)]
            self._unaccounted = self._state, twists, sent, commands
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
        for put, payload in zip(self._observe, wording.farewells(self._state.tick, self._state.poses), strict=True):
            put(payload)

    def _on_change(self, question: Question) -> None:
        """Somebody wants the channel to be another one; it is from the tick that goes on, beacons of it included."""
        try:
            change = decode_change(question.payload)
            changed = events.changed(self._state.channel, {change.path: change.value}, self.scenario.run.dt)
            tick, value = self._state.tick, events.effective(changed, change.path)
            scenario = with_event(self.scenario, tick, change.path, value)
        except (MessageError, ScenarioError) as error:
            self.complaints.add("Change: refused", f"a change: {error}")
            question.refuse(str(error))
            return
        if tick >= self.scenario.ticks:
            question.refuse("the run is over")
            return
        self._state = replace(self._state, channel=changed)
        self.scenario = scenario
        self.keep(scenario)
        if self._recorder is not None:
            self._recorder.change(tick, change.path, value)
        effect = Effect(change.path, value, tick, optimal_separation(scenario.objective, changed))
        self.logger.info("tick %d: %s = %s, r* = %.3f m", tick, effect.path, value, effect.optimal_separation)
        question.answer(encode_effect(effect), "fes.Effect")

    def _on_loss(self, robot: int) -> None:
        self._inbox.nudge()

    def _attend(self, present: Bools) -> None:
        """These robots take part from this tick on."""
        before = self._state
        if (present != before.present).any():
            self._state = simulation.attend(before, present)
            self._attendance.told(before, self._state)
            if self._recorder is not None:
                self._recorder.attend(before.tick, np.flatnonzero(present).tolist())

    def _account(self) -> None:
        """Add the last tick to the tally, and report to observers if it is time."""
        if self._unaccounted is None:
            return
        state, twists, sent, answers = self._unaccounted
        self._unaccounted = None
        self._sums.add(state, twists, self._said)
        if self._recorder is not None and self._ears is not None:
            said = Said(sent, self._ears.heard(state.tick, state.legible), answers)
            self._recorder.add(self._sums, twists, said, self._roster.alive, time.perf_counter() - self._begun)
        if time.perf_counter() - self._told_at >= reporting.PERIOD:
            self._tell()

    def _publish(self, observations: Observations) -> list[bytes]:
        """Put each robot's observation; returns the payloads, to be sent again if need be."""
        # Whom only the scenario has dead must not fall behind.
        addressed = self._state.present | self._attendance.there
        sent = wording.observations(observations, addressed, self._state.since)
        for put, payload in zip(self._observe, sent, strict=True):
            if payload:
                put(payload)
        return sent

    async def _barrier(self, sent: list[bytes]) -> list[tuple[Command, bytes] | None]:
        """Every robot's command for this tick and its payload, in id order; None for those that are not there.

        A robot that is lost or does not answer in time is not there from this tick on.
        """
        answers: list[tuple[Command, bytes] | None] = [None] * len(sent)
        waited = self._state.present.copy()
        missing, begun, patience = int(waited.sum()), time.monotonic(), ASK_AGAIN
        ask_at = begun + patience
        while missing:
            # Messages are only counted here, so junk may wake us too: time is looked at on every pass.
            await self._inbox.wait(missing, max(0.0, ask_at - time.monotonic()))
            for key, payload in self._inbox.drain():
                command = self._read(key, payload)
                if command is not None and payload is not None and waited[command.robot]:
                    answers[command.robot] = command, payload
                    waited[command.robot] = False
                    missing -= 1
                elif (
                    command is not None and answers[command.robot] and self._asked.get(command.robot) != command.tick
                ):
                    self.complaints.add("Command: came twice", f"{key}: a second command for tick {command.tick}")
            if missing:
                waited &= self._attendance.there
                missing = int(waited.sum())
            if missing and time.monotonic() >= ask_at:
                if time.monotonic() - begun >= ANSWER_TIMEOUT:
                    self._attendance.hang(waited)
                    break
                for robot in np.flatnonzero(waited).tolist():
                    self._observe[robot](sent[robot])
                    self._asked[robot] = self._state.tick
                patience *= 2.0
                ask_at = min(time.monotonic() + patience, begun + ANSWER_TIMEOUT)
        self._attend(self._state.present & np.array([answer is not None for answer in answers]))
        return answers

    def _read(self, key: str, payload: bytes | None) -> Command | None:
        """The command in a message if it is one for this tick; anything else is dropped and counted.

        A second answer to the last tick is no fault: its robot was asked again just when it answered.
        """
        try:
            command = wording.command(key, payload, len(self._observe))
            asked = command.tick == self._state.tick - 1 == self._asked.get(command.robot)
            absent = not self._state.present[command.robot] and command.tick <= self._state.tick
            if self._attendance.woke(command.robot) or asked or absent:
                return None
            if command.tick != self._state.tick:
                raise MessageError("Command", "is not for this tick", str(command.tick))
        except MessageError as error:
            self.complaints.add(f"{error.schema}: {error.rule}", f"{key}: {error}")
            return None
        return command

    def _tell(self) -> None:
        now, ticks = time.perf_counter(), self._sums.tally.ticks
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
