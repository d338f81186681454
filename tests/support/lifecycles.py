"""All reachable states of the life cycles of two robots, breadth-first, under all events."""

import pickle
from collections import deque
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from fes.protocol.messages import Join
from world.config.events import ParticipationChange
from world.execution.hosting import LEASE, Membership
from world.execution.lifecycle import Facts, Lifecycle

ROBOTS = 2
SUBSETS = ((True, False), (False, True), (True, True))
"""The robots that are silent together."""

FAULT = "excluded at tick 1: it sent no beacon"

NO_AGENTS = Membership()

Schedule = Mapping[int, ParticipationChange]


class Event(NamedTuple):
    """An event, and its argument."""

    kind: str
    argument: Any = None


@dataclass(frozen=True)
class Snapshot:
    """The life cycles at one moment, and their environment."""

    machine: bytes
    """A stored Lifecycle."""
    now: float
    """Time [s]."""
    tick: int
    """Tick that begins next."""
    continuing: tuple[bool, ...]
    """Robots that have taken part until now."""
    facts: tuple[Facts, ...]
    """The state of each robot, with times from now on."""
    is_running: bool = False

    @property
    def lifecycle(self) -> Lifecycle:
        """A copy of the life cycles."""
        lifecycle: Lifecycle = pickle.loads(self.machine)
        return lifecycle


class Transition(NamedTuple):
    """One event in one state."""

    before: Snapshot
    event: Event
    result: Any
    after: Snapshot


def start(schedule: Schedule, members: Membership = NO_AGENTS) -> Snapshot:
    """The state before any agent has asked."""
    machine = Lifecycle(ROBOTS, schedule, members, 0.0)
    return Snapshot(pickle.dumps(machine), 0.0, 0, (False,) * ROBOTS, _facts(machine, 0.0))


def _facts(lifecycle: Lifecycle, now: float) -> tuple[Facts, ...]:
    """The state of each robot, with times from `now` on."""
    return tuple(
        facts._replace(
            promised_until=max(0.0, facts.promised_until - now), leased_until=max(0.0, facts.leased_until - now)
        )
        for facts in map(lifecycle.facts, range(ROBOTS))
    )


def hosting_events(joins: tuple[Join, ...]) -> list[Event]:
    """All events of `Hosting` in the course of time, with agents that send these `joins`."""
    robots = range(ROBOTS)
    return [
        Event("lease"),
        *(Event("join", join) for join in joins),
        *(Event("token", (robot, alive)) for robot in robots for alive in (True, False)),
        *(Event("exclude", robot) for robot in robots),
        Event("wait"),
    ]


def all_events(joins: tuple[Join, ...]) -> list[Event]:
    """All events but leases and the passage of time, which only `Hosting` knows."""
    robots = range(ROBOTS)
    return [
        *(event for event in hosting_events(joins) if event.kind not in ("lease", "wait")),
        *(Event("silent", mask) for mask in SUBSETS),
        *(Event("message", robot) for robot in robots),
        Event("begin_run"),
        Event("begin_tick"),
    ]


def follow(before: Snapshot, event: Event, last_tick: int) -> Transition | None:
    """The transition of an event; None if it cannot occur in this state. The tick `last_tick` repeats."""
    lifecycle, after = before.lifecycle, before
    result: Any = None
    match event.kind:
        case "lease":
            result = lifecycle.hosting.lease(before.now)
        case "join":
            result = lifecycle.hosting.join(event.argument, before.now)
        case "token":
            lifecycle.token(*event.argument)
        case "message":
            result = lifecycle.message(event.argument)
        case "wait":
            after = replace(before, now=before.now + LEASE)
        case "begin_run":
            if before.is_running or not lifecycle.hosting.hosted.all():
                return None
            lifecycle.begin_run(resumed=False)
            after = replace(before, is_running=True)
        case "exclude":
            lifecycle.hosting.exclude(dict.fromkeys(lifecycle.hosting.group(event.argument), FAULT))
        case _ if not before.is_running:
            return None
        case "silent":
            result = lifecycle.silent(np.array(event.argument))
            present = np.array(before.continuing) & ~np.array(event.argument)
            after = replace(before, continuing=tuple(present.tolist()))
        case "begin_tick":
            result = tuple(lifecycle.begin_tick(before.tick, np.array(before.continuing)).tolist())
            after = replace(before, continuing=result, tick=min(before.tick + 1, last_tick))
    after = replace(after, machine=pickle.dumps(lifecycle), facts=_facts(lifecycle, after.now))
    return Transition(before, event, result, after)


def explore(first: Snapshot, events: list[Event], last_tick: int = 0) -> Iterator[Transition]:
    """Every transition from every state that can be reached by `events`."""
    seen, waiting = {key(first)}, deque([first])
    while waiting:
        before = waiting.popleft()
        for event in events:
            transition = follow(before, event, last_tick)
            if transition is None:
                continue
            yield transition
            state = key(transition.after)
            if state not in seen:
                seen.add(state)
                waiting.append(transition.after)


def key(snapshot: Snapshot) -> Any:
    """The state of life cycles and environment, the same at any time."""
    return snapshot.facts, snapshot.tick, snapshot.continuing, snapshot.is_running
