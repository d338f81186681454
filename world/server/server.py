"""The world on the bus: observations out, commands in, tick after tick."""

import asyncio
import logging
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from fes.arrays.types import Bools
from fes.errors import MessageError, ScenarioError
from fes.protocol import keys, wire
from fes.protocol.channel_change import decode_change, encode_effect
from fes.protocol.messages import Join
from fes.protocol.report import encode_report
from fes.system import fingerprint
from fes.transport.bus import Bus, Query
from fes.transport.drop_log import DropLog
from fes.transport.inbox import Inbox
from world.config.scenario import Scenario, agent_config
from world.execution import marshalling
from world.execution.checkpoint import JOIN, CheckpointWriter
from world.execution.run import Answer, Run
from world.metrics import report_builder, summary
from world.server.beacon_tap import BeaconTap
from world.server.command_gate import CommandGate
from world.server.farewell import Farewell
from world.server.live import LiveClock
from world.server.lockstep import Lockstep
from world.server.participation import Participation
from world.server.registry import RESUME_TIMEOUT, AgentRegistry


class Server:
    """One run of one scenario."""

    def __init__(
        self,
        bus: Bus,
        course: Run,
        name: str,
        run: str,
        rtf: float | None = None,
        keeper: CheckpointWriter | None = None,
        elapsed: float = 0.0,
        guarded: bool = False,
    ) -> None:
        """`elapsed` [s; wall clock] since tick 0, where the run is resumed; `guarded` by access control."""
        self.course, self.name = course, name
        self.logger = logging.getLogger("world")
        self.complaints = DropLog(self.logger)
        robots = range(course.scenario.robots.number)
        self._keeper = keeper
        self.keep: Callable[[Scenario], None] = lambda scenario: None
        """Called with the scenario whenever a person has changed it."""
        self._tap = BeaconTap(bus, run, len(robots), self.complaints, course.beacons, guarded)
        self._inbox = Inbox(asyncio.get_running_loop())
        self._observe = [bus.publisher(keys.observation(run, robot), "fes.Observation") for robot in robots]
        self._report = bus.publisher(keys.report(run), "fes.Report", drop=True)
        hosts, renewed = (keeper.hosts, keeper.renewed) if keeper is not None else ({}, set[int]())
        config = agent_config(course.scenario)
        self._gate = CommandGate(run, hosts)
        bus.subscribe(keys.command(run, "*"), self._inbox.put, self._gate.admits)
        self._roster = AgentRegistry(bus, run, len(robots), config, self.complaints, hosts, renewed, course.excluded)
        self._roster.on_join = self._on_join
        bus.serve(keys.change(run), self._on_change)
        bus.token(keys.world_alive(run))  # last: it says that everything above is in place
        self._attendance = Participation(self._roster, course.scenario, course.excluded)
        self._farewell = Farewell(self._observe, self._roster)
        self._clock = self._make_clock(None if rtf is None else course.scenario.run.dt / rtf)
        self._elapsed = elapsed
        self._begun = self._told_at = self._ended = 0.0
        self._told_tick = course.sums.tally.ticks

    async def gather(self) -> None:
        """Wait until every robot is here; where a run is gone on with, for those that took part, for a while.

        Raises FesError where nobody can be accepted, as it cannot be kept.
        """
        tick, present = self.course.state.tick, self.course.state.present
        if tick == 0:
            self.logger.info("waiting for %d robots", len(self._observe))
            while not self._roster.whole.all():
                self._roster.changed.clear()
                await self._roster.changed.wait()
                if self._keeper is not None:
                    self._keeper.check()
            self._roster.renewed.clear()
        else:
            self.logger.info("waiting for those that took part to come back: %d", np.count_nonzero(present))
            await self._attendance.wait_for(present, RESUME_TIMEOUT)
        self._roster.report_to(self._on_token)
        missing = np.flatnonzero(present & ~self._attendance.there).tolist() if tick else []
        here = f"all robots but {missing} are here" if missing else "all robots are here"
        self.logger.info("%s: %s %s", here, self.name, f"goes on at tick {tick}" if tick else "starts")

    async def run(self) -> None:
        """All ticks of the scenario; ends early, with what was reached, if it is cancelled."""
        course = self.course
        self._begun = self._told_at = time.perf_counter()
        first = course.state.tick
        while not course.is_over:
            present = await self._clock.present(course.state)
            if course.state.tick == first > 0:
                # The world before may have published this tick: who comes back would change what others sense of it.
                present &= course.state.present
            self._attend(present)
            sent = self._publish()
            self._account()  # for the last tick, while the robots think about this one
            if self._keeper is not None and self._keeper.due:
                self._keeper.save(course, self._roster.hosts, self.elapsed)
            answers, present = await self._clock.collect(course.state, sent)
            beacons = await self._hear(answers, present)
            self._attend(present)
            course.take(sent, answers, beacons, self._roster.alive.copy(), self.elapsed)
        self._account()
        self._ended = time.perf_counter()

    def summarize(self) -> dict[str, Any] | None:
        """The summary of the ticks that were run; None before the first."""
        self._account()
        if self.course.sums.tally.ticks == 0:
            return None
        return summary.summarize(self.course.sums, self.name, "processes", self.elapsed)

    @property
    def elapsed(self) -> float:
        """Wall-clock time since tick 0, that without a world left out [s]."""
        return self._elapsed + (self._ended or time.perf_counter()) - (self._begun or time.perf_counter())

    @property
    def overflow(self) -> int:
        """Messages that found no room to wait."""
        return self._inbox.dropped

    @property
    def strangers(self) -> int:
        """Number of commands from processes other than the agent that was accepted for their robot."""
        return self._gate.rejected

    def dismiss(self) -> None:
        """Tell every robot and observer that the run is over."""
        self._account()
        if self.course.sums.tally.ticks:
            self._tell()
        self._farewell.say(marshalling.farewells(self.course.state.tick, self.course.state.poses))

    async def linger(self) -> None:
        """Stay until every robot that takes part has heard that the run is over, for a few seconds at most."""
        await self._farewell.heard(self._attendance.expected(self.course.state))

    def save(self) -> None:
        """Keep the run as it is, to be gone on with."""
        self._account()
        if self._keeper is not None:
            self._keeper.save(self.course, self._roster.hosts, self.elapsed, at_once=True)

    def _make_clock(self, pace: float | None) -> Lockstep | LiveClock:
        lockstep = Lockstep(self._inbox, self._attendance, self.complaints, self._ask, pace)
        deadlines, dt = self.course.sums.deadlines, self.course.scenario.run.dt
        if deadlines is None:
            return lockstep
        return LiveClock(lockstep, self._inbox, self._attendance, self.complaints, deadlines, dt)

    def _on_change(self, question: Query) -> None:
        """Somebody wants the channel to be another one; it is from the tick that goes on, beacons of it included."""
        try:
            change = decode_change(question.payload)
            if self.course.is_over:
                question.refuse("the run is over")
                return
            effect = self.course.change(change.path, change.value)
        except (MessageError, ScenarioError) as error:
            self.complaints.add("Change: refused", f"a change: {error}")
            question.refuse(str(error))
            return
        self.keep(self.course.scenario)
        self.logger.info(
            "tick %d: %s = %s, r* = %.3f m", effect.tick, effect.path, effect.value, effect.optimal_separation
        )
        question.answer(encode_effect(effect), "fes.Effect")

    def _on_join(self, join: Join) -> None:
        if self._keeper is not None:
            self._keeper.note([JOIN, list(join.robots), join.agent, join.arithmetic])
        self.course.readmit(join.robots)
        here = fingerprint.text()
        if join.arithmetic not in ("", here):
            told = "robots %s are computed with %s, and this world with %s: their digits are not those of one loop"
            self.logger.warning(told, list(join.robots), join.arithmetic, here)
        self._gate.expect(join)

    def _on_token(self, robot: int, alive: bool) -> None:
        if not alive:
            self._attendance.lost(robot)
        self._farewell.on_token(robot, alive)
        self._inbox.nudge()

    def _attend(self, present: Bools) -> None:
        """These robots take part from this tick on."""
        before = self.course.state
        if (present == before.present).all():
            return
        self.course.attend(present)
        self._attendance.told(before, self.course.state)

    def _account(self) -> None:
        """Account for the last tick, and keep the run and report to observers if it is time."""
        self.course.account()
        if time.perf_counter() - self._told_at >= report_builder.PERIOD and self.course.sums.tally.ticks:
            self._tell()

    async def _hear(self, answers: list[Answer | None], present: Bools) -> list[bytes]:
        """The beacons of this tick, in id order; a robot at fault is excluded, in `answers` and `present` [n] too.

        The live clock waits for no beacon: a missing one is only late, and its sender is not at fault.
        """
        state = self.course.state
        legible = state.legible & present
        if self.course.sums.deadlines is not None:
            return self._tap.heard(state.tick, legible)
        hosts = dict(self._roster.hosts)
        beacons, faults = await self._tap.judge(state.tick, legible)
        for robot, reason in faults.items():
            group = list(hosts[robot].robots) if robot in hosts else [robot]
            if hosts.get(robot) != self._roster.hosts.get(robot):  # its agent died: the next one is not at fault
                answers[robot], beacons[robot], present[robot] = None, b"", False
                continue
            if robot in self.course.excluded:
                continue  # with another robot of its process
            self.course.exclude(group, f"robot {robot}: {reason}")
            self.logger.warning("robots %s are excluded from tick %d on: %s", group, state.tick, reason)
            for member in group:
                answers[member], beacons[member], present[member] = None, b"", False
        return beacons

    def _publish(self) -> list[bytes]:
        """Put each robot's observation; returns the payloads, to be sent again if need be."""
        # Whom only the scenario has dead must not fall behind.
        sent = self.course.observations(self.course.state.present | self._attendance.there)
        for put, payload in zip(self._observe, sent, strict=True):
            if payload:
                put(payload)
        return sent

    def _ask(self, robot: int, payload: bytes) -> None:
        self._observe[robot](payload)

    def _tell(self) -> None:
        now, ticks = time.perf_counter(), self.course.sums.tally.ticks
        rate = (ticks - self._told_tick) / max(now - self._told_at, 1e-9)
        self._told_at, self._told_tick = now, ticks
        report = report_builder.build(self.course.sums, self.name, self._roster.alive, self.elapsed, rate)
        payload = encode_report(report)
        if len(payload) <= wire.MAX_PAYLOAD:  # beyond, at about 8,000 robots, there is nothing to watch
            self._report(payload)
