"""A recorded run executed again: the world from the recorded Commands, robots from what they sensed and heard.

Whatever comes out is compared with the log, to the bit.
"""

from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from agents import assembly, contacts, crew
from agents.assembly import Assembly
from console.difference import Difference, between, of_payloads, of_reports
from console.log import Log, Tick
from fes import messages
from fes.arrays import Floats
from fes.errors import FesError, MessageError
from fes.messages import Command, Observation
from fes.report import Report
from fes.sensing import Telemetry
from world import events, reporting, simulation, wording
from world.account import Account
from world.recorder import Said
from world.scenario import agent_config
from world.simulation import State
from world.wording import Told

T = TypeVar("T")


class Mismatch(FesError):
    """Executed again, a run came out otherwise."""

    def __init__(self, difference: Difference) -> None:
        self.difference = difference
        super().__init__(difference.told("in the log", "executed again"))


@dataclass(frozen=True, eq=False)
class Moment:
    """One tick, as the world went through it again."""

    recorded: Tick
    state: State
    twists: Floats
    """[n, 2] [m/s, rad/s]"""
    telemetry: Telemetry


def world(log: Log) -> Iterator[Moment]:
    """Every tick of a log, the world moved by the recorded Commands.

    Raises Mismatch where an Observation comes out otherwise, and FesError where the log is damaged.
    """
    again = simulation.create(log.scenario)
    state, told = simulation.start(again), Told(again.ids)
    for tick in log.ticks():
        channel = state.channel
        for path, value in tick.changes:
            channel = events.changed(channel, {path: value}, log.scenario.run.dt)
        if channel is not state.channel:
            state = replace(state, channel=channel)
        if tick.present is not None:
            state = simulation.attend(state, np.isin(again.ids, tick.present))
        sensed = wording.observations(simulation.observe(state), state.present, state.since)
        _compare(tick, tick.said._replace(observations=sensed))
        commands: list[Command | None] = [None] * len(again.ids)
        here = np.flatnonzero(state.present).tolist()
        given = _decoded(tick, messages.decode_command, tick.said.commands, here)
        for robot, command in zip(here, given, strict=True):
            commands[robot] = command
        twists, telemetry = told.read(commands)
        yield Moment(tick, state, twists, telemetry)
        state = simulation.step(again, state, twists)


class Robots:
    """Some robots of a log, executed again tick by tick by their own code."""

    def __init__(self, log: Log, ids: Collection[int]) -> None:
        robots = np.array(sorted(ids), dtype=np.int64)
        self._crew = crew.assemble(agent_config(log.scenario), robots)
        self._state = crew.start(self._crew)
        self._stack = Assembly(robots)
        self._robots = robots.tolist()
        self._before: Tick | None = None

    def step(self, tick: Tick) -> None:
        """Go through a tick, and compare each Beacon and Command; raises Mismatch."""
        here = [robot for robot in self._robots if tick.said.observations[robot]]
        sensed = dict(
            zip(here, _decoded(tick, messages.decode_observation, tick.said.observations, here), strict=True)
        )
        anew = np.array([robot in sensed and sensed[robot].since == tick.number for robot in self._robots])
        if anew.any():
            self._state = crew.forget(self._crew, self._state, anew)
        observations = self._stack.observations(
            [sensed.get(robot) or _absent(tick.number, robot) for robot in self._robots]
        )
        heard = []
        if self._before is not None:
            spoken = self._before.said.beacons
            peers = [peer for peer in np.unique(observations.in_range.peers).tolist() if spoken[peer]]
            heard = _decoded(self._before, messages.decode_beacon, spoken, peers)
        beacons = self._stack.beacons(tick.number - 1, heard)
        self._state, said, twists = crew.step(self._crew, self._state, observations, beacons)
        if not contacts.all_here(self._state.contacts, observations):
            raise FesError(f"tick {tick.number - 1}: a Beacon that was decoded is not in the log")
        learnt = crew.telemetry(self._crew, self._state).learnt
        for robot, beacon, command in assembly.payloads(said, twists, learnt):
            if robot not in sensed:
                continue
            recorded = tick.said.beacons[robot], tick.said.commands[robot]
            for message, one, other in zip(("Beacon", "Command"), recorded, (beacon, command), strict=True):
                if one != other:
                    raise Mismatch(of_payloads(tick.number, message, robot, one, other))
        self._before = tick


def _absent(tick: int, robot: int) -> Observation:
    """What a robot that is not there senses: whatever it makes of it is forgotten when it comes back."""
    nothing = np.zeros(0, dtype=np.int64)
    return Observation(tick, robot, (0.0, 0.0, 0.0), nothing, nothing.astype(np.uint8), over=False, since=0)


def report(sums: Account, like: Report) -> Report:
    """The Report of the last tick of `sums`, with what is of the machine taken from `like`."""
    return reporting.build(sums, like.scenario, like.alive, like.elapsed, like.ticks_per_s)


def check_report(sums: Account, recorded: Report) -> None:
    """Raise Mismatch unless the Report of the last tick of `sums` is the recorded one."""
    found = of_reports(recorded, report(sums, recorded))
    if found is not None:
        raise Mismatch(found)


def _decoded(tick: Tick, decode: Callable[[bytes], T], payloads: list[bytes], robots: Iterable[int]) -> list[T]:
    """The messages of some robots at a tick; raises FesError where one is missing or damaged."""
    found = []
    for robot in robots:
        try:
            found.append(decode(payloads[robot] if robot < len(payloads) else b""))
        except MessageError as error:
            raise FesError(f"tick {tick.number}, robot {robot}: {error}") from None
    return found


def _compare(tick: Tick, again: Said) -> None:
    found = between(tick.number, tick.said, again)
    if found is not None:
        raise Mismatch(found)
