"""One run as the world goes through it: the truth at this tick, the account of it, and what is kept of both.

Nothing here waits for anybody. What comes in from outside, and is not a function of the scenario, is noted before it
is relied on: from a checkpoint and those notes a run is gone through again, to the bit (`world.execution.resume`).
"""

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from fes.arrays.types import Bools, Bytes, Floats, Ints
from fes.model.sensing import Telemetry, no_telemetry
from fes.protocol.channel_change import ChangeResult
from fes.protocol.messages import Command
from fes.recording.layout import TickPayloads
from world.config import events, remarks
from world.config.scenario import Scenario, with_event
from world.execution import marshalling
from world.execution.marshalling import CommandBatch
from world.execution.recorder import Recorder
from world.metrics.collector import MetricsCollector
from world.metrics.optimum import optimal_separation
from world.simulation import crowd, truth
from world.simulation.truth import State

Answer = tuple[Command, bytes]
"""A command, and the payload that it came in."""

Note = Callable[[list[Any]], None]

ATTEND, EXCLUDE, SET, TICK = "attend", "exclude", "set", "tick"
"""Kinds of notes: [ATTEND, tick, robots], [EXCLUDE, tick, robots, reason], [SET, tick, path, value],
[TICK, tick, commands, beacons, alive, elapsed]."""

HELD = 2
"""Number of ticks whose beacons can be recalled: a robot that misses one asks within the next tick."""


class _LastTick(NamedTuple):
    """A tick that is over, and not accounted for yet."""

    state: State
    twists: Floats
    observations: list[bytes]
    commands: list[bytes]
    beacons: list[bytes]
    spoken: Ints
    """Tick of each robot's command [n], -1 for none."""
    alive: Bytes
    elapsed: float


class Run:
    """The state of one run, moved by the robots' commands."""

    def __init__(self, scenario: Scenario, recorder: Recorder | None = None) -> None:
        self.scenario = scenario
        """With what persons have set until now."""
        self.world = truth.create(scenario)
        self.state = truth.start(self.world)
        self.metrics = MetricsCollector(scenario)
        self.telemetry: Telemetry = no_telemetry(self.world.ids)
        self.recorder = recorder
        self.excluded: dict[int, str] = {}
        """Robots at fault and their faults, until another agent joins for them."""
        self.beacons: dict[int, list[bytes]] = {}
        """Tick -> the payload of each robot's Beacon, of the last HELD ticks; empty for a robot that took no part."""
        self.note: Note = lambda note: None
        """Called with each note, as soon as what it is about holds."""
        self._commands = CommandBatch(self.world.ids)
        self._last: _LastTick | None = None

    @property
    def is_over(self) -> bool:
        """Whether all ticks of the scenario are done."""
        return self.state.tick >= self.scenario.ticks

    def attend(self, present: Bools) -> None:
        """The robots of `present` [n] take part from this tick on."""
        if (present == self.state.present).all():
            return
        robots = np.flatnonzero(present).tolist()
        self.state = truth.attend(self.state, present)
        self.note([ATTEND, self.state.tick, robots])
        if self.recorder is not None:
            self.recorder.attend(self.state.tick, robots)

    def exclude(self, robots: list[int], reason: str) -> None:
        """Exclude robots for their fault, until `readmit`; `attend` then determines from which tick on."""
        self.note([EXCLUDE, self.state.tick, robots, reason])
        self.excluded.update(dict.fromkeys(robots, f"excluded at tick {self.state.tick}: {reason}"))
        if self.recorder is not None:
            self.recorder.exclude(self.state.tick, robots, reason)

    def readmit(self, robots: Iterable[int]) -> None:
        """Forget why `robots` were excluded: a new agent hosts them."""
        for robot in robots:
            self.excluded.pop(robot, None)

    def change(self, path: str, value: Any, replayed: bool = False) -> ChangeResult:
        """Set a field of the channel from this tick on; raises ScenarioError if it cannot be set.

        A change that was accepted before is `replayed`, however much memory is free now.
        """
        tick = self.state.tick
        channel = events.changed(self.state.channel, {path: value}, self.scenario.run.dt)
        if not replayed and channel.communication_range > self.state.channel.communication_range:
            crowd.check_contacts(self.state.poses, channel.communication_range)
        value = events.effective(channel, path)
        scenario = with_event(self.scenario, tick, path, value)
        self.note([SET, tick, path, value])
        self.scenario, self.state = scenario, replace(self.state, channel=channel)
        if self.recorder is not None:
            self.recorder.change(tick, path, value)
        unnoticed = remarks.is_unnoticed(scenario.seeking, scenario.channel.formula, channel.formula)
        return ChangeResult(path, value, tick, optimal_separation(self.scenario.objective, channel), unnoticed)

    def observations(self, addressed: Bools) -> list[bytes]:
        """The payload of each robot's Observation of this tick, in id order; empty for all but `addressed` [n]."""
        return marshalling.observations(truth.observe(self.state), addressed, self.state.since)

    def take(
        self, sent: list[bytes], answers: list[Answer | None], beacons: list[bytes], alive: Bytes, elapsed: float
    ) -> None:
        """Move on to the next tick with the robots' `answers` to what was `sent`; a robot without one stands still.

        `beacons` are their payloads in id order; `alive` [n] are those whose token stands; `elapsed` [s; wall clock]
        since tick 0. Input from outside is noted before anything follows from it.
        """
        state = self.state
        commands = [answer[1] if answer else b"" for answer in answers]
        self.beacons[state.tick] = beacons
        self.beacons.pop(state.tick - HELD, None)
        self.note([TICK, state.tick, commands, beacons, alive.tobytes(), elapsed])
        twists, self.telemetry = self._commands.read([answer and answer[0] for answer in answers])
        sensed = [payload if here else b"" for payload, here in zip(sent, state.present.tolist(), strict=True)]
        spoken = np.array([answer[0].tick if answer else -1 for answer in answers])
        self._last = _LastTick(state, twists, sensed, commands, beacons, spoken, alive, elapsed)
        self.state = truth.step(self.world, state, twists)

    def account(self) -> None:
        """Add the tick that is over to the account, if that was not done yet."""
        if self._last is None:
            return
        gone, self._last = self._last, None
        self.metrics.add(gone.state, gone.twists, self.telemetry, gone.spoken)
        if self.recorder is not None:
            said = TickPayloads(gone.observations, gone.beacons, gone.commands)
            self.recorder.add(self.metrics, gone.twists, said, gone.alive, gone.elapsed)
