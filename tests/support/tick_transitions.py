"""All transitions of an agent's tick machines: every event in every state that any sequence of events reaches.

Ticks are bounded, so the states are finitely many. Beside each machine stands a history: what arrived, what was
stepped, and what was refused. It is kept here alone, from the events and the last tick that the machine shows.
"""

import pickle
from collections import Counter
from functools import cache
from itertools import product
from typing import NamedTuple

from agents.control.ticks import Action, LiveTicks, LockstepTicks, Step

LAST = 3
"""States whose last tick is later are not followed."""

LAST_LIVE = {1: 3, 2: 2}
"""The last tick with a live clock, by the number of robots: a machine keeps every later tick that has arrived."""


class Note(NamedTuple):
    """The fields of an observation that a machine reads."""

    tick: int
    robot: int
    since: int
    over: bool = False


class Event(NamedTuple):
    """One observation, and what the shell adds to it."""

    note: Note
    is_new: bool
    is_stored: bool = False


class History(NamedTuple):
    """The events so far that the rules are about."""

    arrived: frozenset[tuple[int, int, Note]] = frozenset()
    """Observations that can still be stepped: tick, robot, note."""
    answered: int = -1
    """Tick of the latest step."""
    refused: int = -1
    """Tick that a restarted world asked for last and in vain."""
    is_over: bool = False


class State(NamedTuple):
    """A machine, as bytes, with its last tick and its history."""

    frozen: bytes
    tick: int
    history: History


class Transition(NamedTuple):
    before: State
    event: Event | None
    """None: all messages that have arrived are read."""
    action: Action | None
    step: Step[Note] | None
    after: State
    skipped: int = 0
    """Ticks that this transition counts as skipped."""

    @property
    def note(self) -> Note:
        assert self.event is not None
        return self.event.note

    @property
    def is_unchanged(self) -> bool:
        return self.before.frozen == self.after.frozen


def notes(robots: tuple[int, ...], tick: int) -> list[Note]:
    """Observations around `tick`: earlier and later ones, of robots that were here before or rejoin, and the last."""
    return [
        Note(near, robot, since, over)
        for near, robot, over in product(range(max(0, tick - 2), tick + 4), robots, (False, True))
        for since in ({0} if over else {0, near})
    ]


def live_notes(robots: tuple[int, ...], state: State) -> list[Note]:
    """Fewer observations than in lockstep, because a live machine has many more states.

    Only the first robot rejoins, and the run ends with the next tick.
    """
    next_tick = state.tick + 1
    near = [note for note in notes(robots, state.tick) if note.tick <= LAST_LIVE[len(robots)]]
    if state.history.is_over:
        return [note for note in near if note.tick == next_tick]
    return [
        note
        for note in near
        if (note.robot == robots[0] or not note.since) and (note.tick == next_tick or not note.over)
    ]


def next_ticks(history: History, tick: int, event: Event, after: int) -> History:
    """The history after an observation in lockstep: the first one of each robot for the next tick counts."""
    note = event.note
    if history.is_over or note.over:
        return history._replace(is_over=True)
    arrived = history.arrived if after == tick else frozenset()
    if note.tick == after + 1 and note.robot not in {robot for _, robot, _ in arrived}:
        arrived |= {(note.tick, note.robot, note)}
    in_vain = event.is_new and not event.is_stored and note.tick < tick
    return history._replace(arrived=arrived, refused=note.tick if in_vain else history.refused)


def newest(history: History, tick: int, event: Event, after: int) -> History:
    """The history after an observation with a live clock: the latest one of each robot and tick counts."""
    note = event.note
    if history.is_over or note.over:
        return history._replace(is_over=True)
    arrived = {item for item in history.arrived if item[:2] != (note.tick, note.robot)}
    if note.tick > after:
        arrived.add((note.tick, note.robot, note))
    return history._replace(arrived=frozenset(arrived))


def stepped(history: History, step: Step[Note] | None) -> History:
    """The history after a step: neither this tick nor an earlier one can be stepped again."""
    if step is None:
        return history
    tick = step.observations[0].tick
    return history._replace(arrived=frozenset(item for item in history.arrived if item[0] > tick), answered=tick)


@cache
def lockstep(robots: tuple[int, ...]) -> list[Transition]:
    """All transitions in lockstep."""
    first = State(pickle.dumps(LockstepTicks[Note](robots)), -1, History())
    transitions, seen, waiting = [], {first}, [first]
    while waiting:
        before = waiting.pop()
        flags = list(product((False, True), (False, True)))
        events = [Event(note, *both) for note in notes(robots, before.tick) for both in flags]
        for event in (None, *events):
            machine: LockstepTicks[Note] = pickle.loads(before.frozen)
            action = machine.receive(*event) if event else None
            step = None if event else machine.step()
            history = next_ticks(before.history, before.tick, event, machine.tick) if event else before.history
            after = State(pickle.dumps(machine), machine.tick, stepped(history, step))
            transitions.append(Transition(before, event, action, step, after))
            if after not in seen and machine.tick <= LAST:
                seen.add(after)
                waiting.append(after)
    return transitions


@cache
def live(robots: tuple[int, ...]) -> list[Transition]:
    """All transitions with a live clock. The count of skipped ticks starts anew in each."""
    first = State(pickle.dumps(LiveTicks[Note](robots)), -1, History())
    transitions, seen, waiting = [], {first}, [first]
    while waiting:
        before = waiting.pop()
        for event in (
            None,
            *(Event(note, is_new) for note in live_notes(robots, before) for is_new in (False, True)),
        ):
            machine: LiveTicks[Note] = pickle.loads(before.frozen)
            action = machine.receive(*event[:2]) if event else None
            step = None if event else machine.step()
            skipped, machine.skipped = machine.skipped, 0
            history = newest(before.history, before.tick, event, machine.tick) if event else before.history
            after = State(pickle.dumps(machine), machine.tick, stepped(history, step))
            transitions.append(Transition(before, event, action, step, after, skipped))
            if after not in seen:
                seen.add(after)
                waiting.append(after)
    return transitions


def kinds(transitions: list[Transition]) -> Counter[str]:
    """Number of transitions by what the machine asked for."""
    return Counter(type(transition.action or transition.step).__name__ for transition in transitions)


def received(transitions: list[Transition]) -> list[Transition]:
    """The observations that reach a machine before the end of the run."""
    running = (transition for transition in transitions if not transition.before.history.is_over)
    return [transition for transition in running if transition.event and not transition.note.over]
