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
from fes.protocol.channel_change import decode_change, encode_result
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
        checkpoints: CheckpointWriter | None = None,
        elapsed: float = 0.0,
        guarded: bool = False,
    ) -> None:
        """`elapsed` [s; wall clock] since tick 0, where the run is resumed; `guarded` by access control."""
        self.run, self.name = course, name
        self.logger = logging.getLogger("world")
        self.drops = DropLog(self.logger)
        robots = range(course.scenario.robots.number)
        self._checkpoints = checkpoints
        self.keep: Callable[[Scenario], None] = lambda scenario: None
        """Called with the scenario whenever a person has changed it."""
        self._tap = BeaconTap(bus, run, len(robots), self.drops, course.beacons, guarded)
        self._inbox = Inbox(asyncio.get_running_loop())
        self._observe = [bus.declare_publisher(keys.observation(run, robot), "fes.Observation") for robot in robots]
        self._report = bus.declare_publisher(keys.report(run), "fes.Report", drop=True)
        hosts, renewed = (checkpoints.hosts, checkpoints.renewed) if checkpoints is not None else ({}, set[int]())
        config = agent_config(course.scenario)
        self._gate = CommandGate(run, hosts)
        bus.declare_subscriber(keys.command(run, "*"), self._inbox.put, self._gate.admits)
        self._registry = AgentRegistry(bus, run, len(robots), config, self.drops, hosts, renewed, course.excluded)
        self._registry.on_join = self._on_join
        bus.declare_queryable(keys.change(run), self._on_change)
        bus.declare_token(keys.world_alive(run))  # last: it says that everything above is in place
        self._participation = Participation(self._registry, course.scenario, course.excluded)
        self._farewell = Farewell(self._observe, self._registry)
        self._clock = self._make_clock(None if rtf is None else course.scenario.run.dt / rtf)
        self._elapsed = elapsed
        self._begun = self._told_at = self._ended = 0.0
        self._told_tick = course.metrics.link_errors.ticks

    async def gather(self) -> None:
        """Wait until every robot is here; where a run is gone on with, for those that took part, for a while.

        Raises FesError where nobody can be accepted, as it cannot be kept.
        """
        tick, present = self.run.state.tick, self.run.state.present
        if tick == 0:
            self.logger.info("waiting for %d robots", len(self._observe))
            while not self._registry.whole.all():
                self._registry.changed.clear()
                await self._registry.changed.wait()
                if self._checkpoints is not None:
                    self._checkpoints.check()
            self._registry.renewed.clear()
        else:
            self.logger.info("waiting for those that took part to come back: %d", np.count_nonzero(present))
            await self._participation.wait_for(present, RESUME_TIMEOUT)
        self._registry.report_to(self._on_token)
        missing = np.flatnonzero(present & ~self._participation.there).tolist() if tick else []
        here = f"all robots but {missing} are here" if missing else "all robots are here"
        self.logger.info("%s: %s %s", here, self.name, f"goes on at tick {tick}" if tick else "starts")

    async def main_loop(self) -> None:
        """All ticks of the scenario; ends early, with what was reached, if it is cancelled."""
        run = self.run
        self._begun = self._told_at = time.perf_counter()
        first = run.state.tick
        while not run.is_over:
            present = await self._clock.present(run.state)
            if run.state.tick == first > 0:
                # The world before may have published this tick: who comes back would change what others sense of it.
                present &= run.state.present
            self._attend(present)
            sent = self._publish()
            self._account()  # for the last tick, while the robots think about this one
            if self._checkpoints is not None and self._checkpoints.due:
                self._checkpoints.save(run, self._registry.hosts, self.elapsed)
            answers, present = await self._clock.collect(run.state, sent)
            beacons = await self._hear(answers, present)
            self._attend(present)
            run.take(sent, answers, beacons, self._registry.alive.copy(), self.elapsed)
        self._account()
        self._ended = time.perf_counter()

    def summarize(self) -> dict[str, Any] | None:
        """The summary of the ticks that were run; None before the first."""
        self._account()
        if self.run.metrics.link_errors.ticks == 0:
            return None
        return summary.summarize(self.run.metrics, self.name, "processes", self.elapsed)

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
        if self.run.metrics.link_errors.ticks:
            self._tell()
        self._farewell.say(marshalling.farewells(self.run.state.tick, self.run.state.poses))

    async def linger(self) -> None:
        """Stay until every robot that takes part has heard that the run is over, for a few seconds at most."""
        await self._farewell.heard(self._participation.expected(self.run.state))

    def save(self) -> None:
        """Keep the run as it is, to be gone on with."""
        self._account()
        if self._checkpoints is not None:
            self._checkpoints.save(self.run, self._registry.hosts, self.elapsed, at_once=True)

    def _make_clock(self, pace: float | None) -> Lockstep | LiveClock:
        lockstep = Lockstep(self._inbox, self._participation, self.drops, self._ask, pace)
        deadlines, dt = self.run.metrics.deadlines, self.run.scenario.run.dt
        if deadlines is None:
            return lockstep
        return LiveClock(lockstep, self._inbox, self._participation, self.drops, deadlines, dt)

    def _on_change(self, query: Query) -> None:
        """Somebody wants the channel to be another one; it is from the tick that goes on, beacons of it included."""
        try:
            change = decode_change(query.payload)
            if self.run.is_over:
                query.reply_err("the run is over")
                return
            effect = self.run.change(change.path, change.value)
        except (MessageError, ScenarioError) as error:
            self.drops.reject("Change: refused", f"a change: {error}")
            query.reply_err(str(error))
            return
        self.keep(self.run.scenario)
        self.logger.info(
            "tick %d: %s = %s, r* = %.3f m", effect.tick, effect.path, effect.value, effect.optimal_separation
        )
        query.reply(encode_result(effect), "fes.Effect")

    def _on_join(self, join: Join) -> None:
        if self._checkpoints is not None:
            self._checkpoints.note([JOIN, list(join.robots), join.agent, join.arithmetic])
        self.run.readmit(join.robots)
        here = fingerprint.text()
        if join.arithmetic not in ("", here):
            told = "robots %s are computed with %s, and this world with %s: their digits are not those of one loop"
            self.logger.warning(told, list(join.robots), join.arithmetic, here)
        self._gate.expect(join)

    def _on_token(self, robot: int, alive: bool) -> None:
        if not alive:
            self._participation.lost(robot)
        self._farewell.on_token(robot, alive)
        self._inbox.nudge()

    def _attend(self, present: Bools) -> None:
        """These robots take part from this tick on."""
        before = self.run.state
        if (present == before.present).all():
            return
        self.run.attend(present)
        self._participation.told(before, self.run.state)

    def _account(self) -> None:
        """Account for the last tick, and keep the run and report to observers if it is time."""
        self.run.account()
        if time.perf_counter() - self._told_at >= report_builder.PERIOD and self.run.metrics.link_errors.ticks:
            self._tell()

    async def _hear(self, answers: list[Answer | None], present: Bools) -> list[bytes]:
        """The beacons of this tick, in id order; a robot at fault is excluded, in `answers` and `present` [n] too.

        The live clock waits for no beacon: a missing one is only late, and its sender is not at fault.
        """
        state = self.run.state
        legible = state.decodable & present
        if self.run.metrics.deadlines is not None:
            return self._tap.heard(state.tick, legible)
        hosts = dict(self._registry.hosts)
        beacons, faults = await self._tap.judge(state.tick, legible)
        for robot, reason in faults.items():
            group = list(hosts[robot].robots) if robot in hosts else [robot]
            if hosts.get(robot) != self._registry.hosts.get(robot):  # its agent died: the next one is not at fault
                answers[robot], beacons[robot], present[robot] = None, b"", False
                continue
            if robot in self.run.excluded:
                continue  # with another robot of its process
            self.run.exclude(group, f"robot {robot}: {reason}")
            self.logger.warning("robots %s are excluded from tick %d on: %s", group, state.tick, reason)
            for member in group:
                answers[member], beacons[member], present[member] = None, b"", False
        return beacons

    def _publish(self) -> list[bytes]:
        """Put each robot's observation; returns the payloads, to be sent again if need be."""
        # Whom only the scenario has dead must not fall behind.
        sent = self.run.observations(self.run.state.present | self._participation.there)
        for put, payload in zip(self._observe, sent, strict=True):
            if payload:
                put(payload)
        return sent

    def _ask(self, robot: int, payload: bytes) -> None:
        self._observe[robot](payload)

    def _tell(self) -> None:
        now, ticks = time.perf_counter(), self.run.metrics.link_errors.ticks
        rate = (ticks - self._told_tick) / max(now - self._told_at, 1e-9)
        self._told_at, self._told_tick = now, ticks
        report = report_builder.build(self.run.metrics, self.name, self._registry.alive, self.elapsed, rate)
        payload = encode_report(report)
        if len(payload) <= wire.MAX_PAYLOAD:  # beyond, at about 8,000 robots, there is nothing to watch
            self._report(payload)
