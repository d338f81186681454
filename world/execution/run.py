"""One run of a scenario: the truth at this tick, the metrics so far, and their log and notes.

A run waits for nothing. Each external input is noted before it takes effect. A checkpoint and these notes suffice to
execute the run again, to the bit (`world.execution.resume`).
"""

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from fes.arrays.types import Bools, Bytes, Floats, Ints
from fes.errors import FesError, ScenarioError
from fes.model.sensing import Telemetry, no_telemetry
from fes.protocol.channel_change import ChangeResult
from fes.protocol.messages import Command
from fes.recording.layout import TickPayloads
from world.config import events, remarks
from world.config.outside import trace_file
from world.config.scenario import Scenario, with_event
from world.execution import marshalling
from world.execution.marshalling import CommandBatch
from world.execution.recorder import Recorder
from world.metrics.collector import MetricsCollector
from world.metrics.team.target import sought_separation
from world.simulation import crowd, truth
from world.simulation.truth import State

Answer = tuple[Command, bytes]
"""A command, and the payload that it came in."""

Note = Callable[[list[Any]], None]

ATTEND, EXCLUDE, SET, TICK = "attend", "exclude", "set", "tick"
"""Kinds of notes: [ATTEND, tick, robots], [EXCLUDE, tick, robots, reason], [SET, tick, path, value],
[TICK, tick, commands, beacons, alive, elapsed]."""

RECALLABLE = 2
"""Number of ticks whose beacons can be recalled: a robot that misses a beacon asks for it within the next tick."""


def ignore(note: list[Any]) -> None:
    """Drop a note: the run keeps no checkpoints."""


class _LastTick(NamedTuple):
    """A tick that is over, and not recorded yet."""

    state: State
    twists: Floats
    observations: list[bytes]
    commands: list[bytes]
    beacons: list[bytes]
    answered: Ints
    """Tick of each robot's command [n], -1 for none."""
    alive: Bytes
    elapsed: float


class Run:
    """The state of one run, moved by the robots' commands."""

    def __init__(self, scenario: Scenario, recorder: Recorder | None = None, note: Note = ignore) -> None:
        """`note` is called with each note, as soon as the input that it describes takes effect."""
        self.scenario = scenario
        """The scenario, with all changes by persons until now."""
        self.world = truth.create(scenario)
        self.state = truth.start(self.world)
        self.metrics = MetricsCollector(scenario)
        self.telemetry: Telemetry = no_telemetry(self.world.ids)
        self.recorder = recorder
        self.excluded: dict[int, str] = {}
        """Robot -> its fault, until another agent joins for it."""
        self.beacons: dict[int, list[bytes]] = {}
        """Tick -> the payload of each robot's Beacon, of RECALLABLE ticks; empty for a robot that took no part."""
        self.note = note
        self._commands = CommandBatch(self.world.ids)
        self._last: _LastTick | None = None

    @property
    def is_over(self) -> bool:
        """True if all ticks of the scenario have been executed."""
        return self.state.tick >= self.scenario.ticks

    def attend(self, present: Bools) -> None:
        """Let the robots of `present` [n] take part from this tick on."""
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

        A `replayed` change was accepted before, and is not checked against the memory that is free now.
        """
        tick = self.state.tick
        if path.removeprefix(events.PREFIX) in (trace_file.TRACE, trace_file.CHECKSUM):
            raise ScenarioError(path, "cannot be set during a run: name the file in the scenario")
        channel = events.changed(self.state.channel, {path: value}, self.scenario.run.dt)
        if not replayed and channel.communication_range > self.state.channel.communication_range:
            crowd.check_contacts(self.state.poses, channel.communication_range)
        value = events.effective(channel, path)
        scenario = with_event(self.scenario, tick, path, value)
        try:
            optimal = sought_separation(scenario, channel, int(np.count_nonzero(self.state.present)))
        except FesError as error:
            raise ScenarioError(path, str(error)) from None
        self.note([SET, tick, path, value])
        self.scenario, self.state = scenario, replace(self.state, channel=channel)
        if self.recorder is not None:
            self.recorder.change(tick, path, value)
        unnoticed = remarks.is_unnoticed(scenario, channel.formula)
        return ChangeResult(path, value, tick, optimal, unnoticed)

    def observations(self, addressed: Bools) -> list[bytes]:
        """The payload of each robot's Observation of this tick, in id order; empty for all but `addressed` [n]."""
        return marshalling.observations(truth.observe(self.state), addressed, self.state.since)

    def farewells(self) -> list[bytes]:
        """The payload that tells each robot that the run is over, in id order."""
        return marshalling.farewells(truth.observe(self.state))

    def advance(
        self, sent: list[bytes], answers: list[Answer | None], beacons: list[bytes], alive: Bytes, elapsed: float
    ) -> None:
        """Advance to the next tick with the robots' `answers` to the observations `sent`.

        All lists are in id order. A robot whose answer is None stands still. `beacons` are payloads; `alive` [n] is 1
        for each robot with a token; `elapsed` is the wall-clock time since tick 0 [s]. The input is noted before it
        takes effect.
        """
        state = self.state
        commands = [answer[1] if answer else b"" for answer in answers]
        self.beacons[state.tick] = beacons
        self.beacons.pop(state.tick - RECALLABLE, None)
        self.note([TICK, state.tick, commands, beacons, alive.tobytes(), elapsed])
        twists, self.telemetry = self._commands.read([answer and answer[0] for answer in answers])
        sensed = [payload if present else b"" for payload, present in zip(sent, state.present.tolist(), strict=True)]
        answered = np.array([answer[0].tick if answer else -1 for answer in answers])
        self._last = _LastTick(state, twists, sensed, commands, beacons, answered, alive, elapsed)
        self.state = truth.step(self.world, state, twists)

    def record_tick(self) -> None:
        """Add the tick that is over to metrics and log, if that was not done yet."""
        if self._last is None:
            return
        last, self._last = self._last, None
        self.metrics.add(last.state, last.twists, self.telemetry, last.answered)
        if self.recorder is not None:
            payloads = TickPayloads(last.observations, last.beacons, last.commands)
            self.recorder.add(self.metrics, last.twists, payloads, last.alive, last.elapsed)
