"""The world on the bus: observations out, commands in, tick after tick."""

import asyncio
import logging
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from fes.arrays.types import Bools
from fes.errors import MessageError, ScenarioError
from fes.protocol import keys
from fes.protocol.channel_change import decode_change, encode_result
from fes.protocol.messages import Join
from fes.system import fingerprint
from fes.transport.bus import Bus, Query
from fes.transport.drop_log import DropLog
from fes.transport.inbox import Inbox
from world.config.scenario import Scenario, agent_config
from world.execution.checkpoint import JOIN, CheckpointWriter
from world.execution.hosting import RESUME_TIMEOUT, Membership
from world.execution.lifecycle import Lifecycle
from world.execution.run import Answer, Run
from world.metrics import summary
from world.server import participation
from world.server.beacon_tap import BeaconTap
from world.server.command_gate import CommandGate
from world.server.farewell import Farewell
from world.server.live import LiveClock
from world.server.lockstep import Lockstep
from world.server.registry import AgentRegistry, RunInfo
from world.server.report_publisher import ReportPublisher


@dataclass(frozen=True)
class Options:
    """Settings of a server, in addition to its run."""

    rtf: float | None = None
    """Pace [simulated seconds per second]; None for full speed."""
    checkpoints: CheckpointWriter | None = None
    elapsed: float = 0.0
    """Wall-clock time since tick 0 at which the run is resumed [s]."""
    guarded: bool = False
    """True if access control protects the run."""
    on_change: Callable[[Scenario], None] | None = None
    """Called with the scenario whenever a person has changed it."""


class Server:
    """The world of one run: it gathers the agents, executes all ticks with them, and dismisses them."""

    def __init__(self, bus: Bus, run: Run, scenario_name: str, run_name: str, options: Options | None = None) -> None:
        """`run_name` is the name of the run in every key."""
        options = Options() if options is None else options
        self.run, self.scenario_name = run, scenario_name
        self.logger = logging.getLogger("world")
        self.drops = DropLog(self.logger)
        robots = run.scenario.robots.number
        self._checkpoints, self._on_scenario_change = options.checkpoints, options.on_change
        self._tap = BeaconTap(bus, run_name, robots, self.drops, run.beacons, options.guarded)
        self._inbox = Inbox(asyncio.get_running_loop())
        self._observe = [
            bus.declare_publisher(keys.observation(run_name, robot), "fes.Observation") for robot in range(robots)
        ]
        self._reports = ReportPublisher(bus, run_name, scenario_name, run.metrics)
        members = Membership(excluded=run.excluded)
        if self._checkpoints is not None:
            members = Membership(self._checkpoints.hosts, self._checkpoints.renewed, run.excluded)
        self.lifecycle = Lifecycle(robots, run.scenario.participation, members, time.monotonic())
        """The life cycle of each robot."""
        self._gate = CommandGate(run_name, members.hosts)
        bus.declare_subscriber(keys.command(run_name, "*"), self._inbox.put, self._gate.admits)
        info = RunInfo(run_name, robots, agent_config(run.scenario))
        self._registry = AgentRegistry(
            bus, info, self.drops, self.lifecycle, on_join=self._on_join, on_token=self._on_token
        )
        self._farewell = Farewell(self._observe, self.lifecycle.hosting.alive, self._registry.changed)
        bus.declare_queryable(keys.change(run_name), self._on_change)
        bus.declare_token(keys.world_alive(run_name))  # last: it promises that all of the above is in place
        self.clock = self._create_clock(None if options.rtf is None else run.scenario.run.dt / options.rtf)
        """The beginning and the end of each tick."""
        self._elapsed = options.elapsed
        self._begun = self._ended = 0.0  # of the main loop [s; performance counter]

    async def gather(self) -> None:
        """Wait for all robots; in a resumed run for those that took part, for RESUME_TIMEOUT at most.

        Raises FesError if no agent can be accepted, because the journal cannot be written.
        """
        tick, present = self.run.state.tick, self.run.state.present
        if tick == 0:
            self.logger.info("waiting for %d robots", len(self._observe))
            while not self.lifecycle.hosting.hosted.all():
                self._registry.changed.clear()
                await self._registry.changed.wait()
                if self._checkpoints is not None:
                    self._checkpoints.check()
        else:
            self.logger.info("waiting for the robots that took part: %d", np.count_nonzero(present))
            await self._registry.wait_for(present, RESUME_TIMEOUT)
        self.lifecycle.begin_run(resumed=tick > 0)
        missing = np.flatnonzero(present & ~self.lifecycle.reachable).tolist() if tick else []
        robots = f"all robots but {missing} are here" if missing else "all robots are here"
        self.logger.info("%s: %s %s", robots, self.scenario_name, f"resumes at tick {tick}" if tick else "starts")

    async def main_loop(self) -> None:
        """Execute all ticks of the scenario; if it is cancelled, the executed ticks count."""
        run = self.run
        self._begun = time.perf_counter()
        self._reports.start()
        first = run.state.tick
        while not run.is_over:
            present = await self.clock.present(run.state)
            if run.state.tick == first > 0:
                present &= run.state.present  # a robot that rejoins now would change what may be published already
            self._attend(present)
            sent = self._publish_observations()
            self._record_tick()  # the previous one, while the robots compute this one
            if self._checkpoints is not None and self._checkpoints.due:
                self._checkpoints.save(run, self.lifecycle.hosting.hosts, self.elapsed)

            answers, present = await self.clock.collect(run.state, sent)
            beacons = await self._judge_beacons(answers, present)
            self._attend(present)
            run.advance(sent, answers, beacons, self.lifecycle.hosting.alive.copy(), self.elapsed)
        self._record_tick()
        self._ended = time.perf_counter()

    def summarize(self) -> dict[str, Any] | None:
        """The summary of the executed ticks; None before the first."""
        self._record_tick()
        if self.run.metrics.link_errors.ticks == 0:
            return None
        return summary.summarize(self.run.metrics, self.scenario_name, "processes", self.elapsed)

    @property
    def elapsed(self) -> float:
        """Wall-clock time since tick 0, without the time that the run had no world [s]."""
        return self._elapsed + (self._ended or time.perf_counter()) - (self._begun or time.perf_counter())

    @property
    def rejected_commands(self) -> int:
        """Number of commands from processes other than the agent that was accepted for their robot."""
        return self._gate.rejected

    def log_drops(self) -> None:
        """Log the total of each kind of dropped message."""
        self.drops.log_total(self._inbox.dropped, self._gate.rejected)

    def dismiss(self) -> None:
        """Tell each robot and observer that the run is over."""
        self._record_tick()
        if self.run.metrics.link_errors.ticks:
            self._reports.publish(self.lifecycle.hosting.alive, self.elapsed)
        self._farewell.publish(self.run.farewells())

    async def linger(self) -> None:
        """Wait a few seconds at most until each robot that takes part knows that the run is over."""
        await self._farewell.delivered(self.lifecycle.expected(self.run.state.tick))

    def save(self) -> None:
        """Write a checkpoint of the run at this tick."""
        self._record_tick()
        if self._checkpoints is not None:
            self._checkpoints.save(self.run, self.lifecycle.hosting.hosts, self.elapsed, at_once=True)

    def _create_clock(self, pace: float | None) -> Lockstep | LiveClock:
        lockstep = Lockstep(self._inbox, self.lifecycle, self.drops, self._observe, pace)
        deadlines, dt = self.run.metrics.deadlines, self.run.scenario.run.dt
        if deadlines is None:
            return lockstep
        return LiveClock(lockstep, self._inbox, self.lifecycle, self.drops, deadlines, dt)

    def _on_change(self, query: Query) -> None:
        """Change the channel on a person's request: from the tick that is running, its beacons included."""
        try:
            change = decode_change(query.payload)
            if self.run.is_over:
                query.reply_err("the run is over")
                return
            result = self.run.change(change.path, change.value)
        except (MessageError, ScenarioError) as error:
            self.drops.reject("Change: refused", f"a change: {error}")
            query.reply_err(str(error))
            return
        if self._on_scenario_change is not None:
            self._on_scenario_change(self.run.scenario)
        text = "tick %d: %s = %s, r* = %.3f m"
        self.logger.info(text, result.tick, result.path, result.value, result.optimal_separation)
        query.reply(encode_result(result), "fes.Effect")

    def _on_join(self, join: Join) -> None:
        if self._checkpoints is not None:
            self._checkpoints.note([JOIN, list(join.robots), join.agent, join.arithmetic])
        self.run.readmit(join.robots)
        own = fingerprint.text()
        if join.arithmetic not in ("", own):
            warning = "robots %s are computed with %s, this world with %s: digits may differ from those of one loop"
            self.logger.warning(warning, list(join.robots), join.arithmetic, own)
        self._gate.expect(join)

    def _on_token(self, robot: int, alive: bool) -> None:
        if not self.lifecycle.is_running:
            if not alive:
                self.logger.info("robot %d left before the start", robot)
            return
        self._farewell.on_token(robot, alive)
        self._inbox.nudge()

    def _attend(self, present: Bools) -> None:
        """Let the robots of `present` [n] take part from this tick on."""
        before = self.run.state
        if present.tobytes() == before.present.tobytes():  # the usual tick; a comparison of arrays costs more
            return
        self.run.attend(present)
        participation.log_changes(before, self.run.state)

    def _record_tick(self) -> None:
        """Add the last tick to metrics and log, and report to observers if it is time."""
        self.run.record_tick()
        if self._reports.is_due:
            self._reports.publish(self.lifecycle.hosting.alive, self.elapsed)

    async def _judge_beacons(self, answers: list[Answer | None], present: Bools) -> list[bytes]:
        """The beacons of this tick, in id order; excludes robots at fault, also from `answers` and `present` [n].

        The live clock waits for no beacon: a missing one is only late, and its sender is not at fault.
        """
        tick, decodable = self.run.state.tick, self.run.state.decodable & present
        if self.run.metrics.deadlines is not None:
            return self._tap.received(tick, decodable)
        hosting = self.lifecycle.hosting
        hosts = dict(hosting.hosts)
        beacons, faults = await self._tap.judge(tick, decodable)
        for robot, fault in faults.items():
            group = list(hosts[robot].robots) if robot in hosts else [robot]
            if hosts.get(robot) != hosting.hosts.get(robot):  # a new agent hosts it, and is not at fault
                group = [robot]
            elif robot in self.run.excluded:
                continue  # excluded with another robot of its process
            else:
                self.run.exclude(group, f"robot {robot}: {fault}")
                hosting.exclude({member: self.run.excluded[member] for member in group})
                self.logger.warning("robots %s are excluded from tick %d on: %s", group, tick, fault)
            for member in group:
                answers[member], beacons[member], present[member] = None, b"", False
        return beacons

    def _publish_observations(self) -> list[bytes]:
        """Publish each robot's observation; returns the payloads, which may be sent again."""
        # Agents whose robots are dead only by schedule still receive observations, so that they keep up.
        payloads = self.run.observations(self.run.state.present | self.lifecycle.reachable)
        for put, payload in zip(self._observe, payloads, strict=True):
            if payload:
                put(payload)
        return payloads
