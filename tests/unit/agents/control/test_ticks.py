"""The choice of the tick to answer: rules that hold in every transition that any sequence of events reaches."""

import pytest

from agents.control.ticks import Behind, End, Reject, Resend, Step
from tests.support.tick_transitions import Note, Transition, kinds, live, lockstep, received

TEAMS = pytest.mark.parametrize("robots", [(3,), (2, 5)], ids=str)


def steps(transitions: list[Transition]) -> list[tuple[Transition, list[Note]]]:
    """Transitions that answer a tick, with the observations that they answer."""
    return [(transition, transition.step.observations) for transition in transitions if transition.step]


@TEAMS
def test_the_enumeration_visits_every_kind_of_transition(robots: tuple[int, ...]) -> None:
    assert len(lockstep(robots)) > 8_000
    assert len(live(robots)) > 19_000
    for kind in (Step, Resend, Reject, Behind, End):
        assert kinds(lockstep(robots))[kind.__name__] > 50
    assert set(kinds(live(robots))) == {"NoneType", "End", "Step"}
    assert kinds(live(robots))["Step"] > 900


@TEAMS
def test_in_lockstep_each_tick_is_stepped_once_and_in_its_turn(robots: tuple[int, ...]) -> None:
    rejoined = 0
    for transition, observations in steps(lockstep(robots)):
        tick, answered = observations[0].tick, transition.before.history.answered
        assert tick > answered
        if tick > answered + 1:  # only a robot that takes part from this tick has missed those before
            assert tick in {note.since for note in observations}
            rejoined += 1
        assert transition.after.tick == tick
    assert rejoined > 20


@TEAMS
def test_a_step_has_one_observation_per_robot_in_id_order(robots: tuple[int, ...]) -> None:
    for transition, observations in steps(lockstep(robots)) + steps(live(robots)):
        assert tuple(note.robot for note in observations) == robots
        assert len({note.tick for note in observations}) == 1
        assert {(note.tick, note.robot, note) for note in observations} <= transition.before.history.arrived


@TEAMS
def test_in_lockstep_a_tick_is_stepped_as_soon_as_its_last_observation_has_arrived(robots: tuple[int, ...]) -> None:
    for transition in lockstep(robots):
        if transition.event is None and not transition.before.history.is_over:
            next_tick = transition.before.tick + 1
            arrived = {robot for tick, robot, _ in transition.before.history.arrived if tick == next_tick}
            assert (transition.step is not None) == (arrived == set(robots))


@TEAMS
def test_nothing_is_answered_after_the_end(robots: tuple[int, ...]) -> None:
    ended = 0
    for transition in lockstep(robots) + live(robots):
        is_last = transition.event is not None and transition.note.over
        if transition.before.history.is_over or is_last:
            ended += 1
            assert transition.step is None
            assert transition.action == (End(transition.before.tick) if transition.event else None)
            assert transition.after.tick == transition.before.tick
        else:
            assert not isinstance(transition.action, End)
    assert ended > 10_000


@TEAMS
def test_in_lockstep_a_repeated_tick_is_answered_from_the_outbox_and_changes_nothing(robots: tuple[int, ...]) -> None:
    for transition in received(lockstep(robots)):
        assert transition.event is not None
        note, tick = transition.note, transition.before.tick
        is_repeated = note.tick == tick or (note.tick < tick and transition.event.is_new)
        if is_repeated and transition.event.is_stored:
            assert transition.action == Resend(note.tick, note.robot)
            assert transition.is_unchanged
        else:
            assert not isinstance(transition.action, Resend)


@TEAMS
def test_an_agent_ends_when_a_restarted_world_asks_twice_for_a_tick_that_is_not_stored(
    robots: tuple[int, ...],
) -> None:
    for transition in received(lockstep(robots)):
        assert transition.event is not None
        note, tick, history = transition.note, transition.before.tick, transition.before.history
        if transition.event.is_new and not transition.event.is_stored and note.tick < tick:
            text = f"the world is back at tick {note.tick}, but tick {tick} was answered already"
            assert transition.action == (Behind(text) if history.refused == note.tick else Reject(note.tick))
        else:
            assert not isinstance(transition.action, Behind)


@TEAMS
def test_in_lockstep_an_early_or_an_old_tick_is_rejected_and_changes_nothing(robots: tuple[int, ...]) -> None:
    early = old = 0
    for transition in received(lockstep(robots)):
        assert transition.event is not None
        note, tick = transition.note, transition.before.tick
        is_early = note.tick > tick + 1 and note.since != note.tick
        is_old = note.tick < tick and not transition.event.is_new
        if is_early or is_old:
            # before its first tick, an agent that has joined counts nothing
            assert transition.action == (Reject(note.tick) if tick >= 0 else None)
            assert transition.is_unchanged
            early, old = early + is_early, old + is_old
    assert early > 100
    assert old > 100


@TEAMS
def test_in_lockstep_the_last_tick_changes_only_by_a_step_or_to_the_tick_before_a_rejoining(
    robots: tuple[int, ...],
) -> None:
    for transition in received(lockstep(robots)):
        note, tick = transition.note, transition.before.tick
        rejoins = note.tick > tick + 1 and note.since == note.tick
        assert transition.after.tick == (note.tick - 1 if rejoins else tick)
        assert not (rejoins and transition.action)


@TEAMS
def test_a_live_agent_answers_the_newest_complete_tick(robots: tuple[int, ...]) -> None:
    for transition in live(robots):
        if transition.event is None and not transition.before.history.is_over:
            arrived = {(tick, robot) for tick, robot, _ in transition.before.history.arrived}
            complete = {tick for tick, _ in arrived if all((tick, robot) in arrived for robot in robots)}
            stepped = {note.tick for note in transition.step.observations} if transition.step else set()
            assert stepped == ({max(complete)} if complete else set())


@TEAMS
def test_a_live_agent_never_goes_back_unless_the_world_is_new(robots: tuple[int, ...]) -> None:
    resumed = 0
    for transition in live(robots):
        before, after = transition.before.tick, transition.after.tick
        if after < before:
            assert transition.event is not None
            assert transition.event.is_new
            assert after == transition.note.tick - 1
            resumed += 1
        elif after > before:
            assert transition.step
    assert resumed > 400
    for transition in received(live(robots)):
        assert transition.event is not None
        if transition.note.tick <= transition.before.tick:  # a late tick has no effect, or the world resumed from it
            assert transition.is_unchanged or transition.event.is_new


@TEAMS
def test_a_live_agent_counts_the_ticks_that_it_skipped_while_it_took_part(robots: tuple[int, ...]) -> None:
    counted = 0
    for transition in live(robots):
        skipped = 0
        if transition.step and transition.before.tick >= 0:
            note = transition.step.observations[0]
            took_part = note.since <= transition.before.tick
            skipped = len(range(transition.before.tick + 1, note.tick)) if took_part else 0
        assert transition.skipped == skipped
        counted += skipped
    assert counted > 20
