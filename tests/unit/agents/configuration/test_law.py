"""The law in crews of the product: plans, marks and weights of robots that start, restart, join and die."""

import pickle
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from agents.configuration import planning
from agents.configuration.law import MarksAndPlans, State
from agents.control import crew
from agents.runtime.reception import Receiver
from fes.arrays.types import Bools, Floats
from fes.extension.neighborhood import LinkGeometry, Neighborhood
from fes.extension.protocols import Formed
from fes.model.sensing import no_beacons
from fes.shapes.choice import shape
from tests.support import loop
from tests.support.configuration_runs import moments, scenario, spacing, watch
from world.config.scenario import Scenario, agent_config
from world.simulation import truth


def team(kind: str = "medium", n: int = 6, seconds: float = 8.0, **settings: Any) -> Scenario:
    return scenario(kind, n, 1, seconds, "fixed", **settings)


class Recorder:
    """A formation law that keeps its last result."""

    def __init__(self, law: MarksAndPlans) -> None:
        self.law, self.declared, self.details = law, law.declared, law.details
        self.last: Formed

    def start(self) -> State:
        return self.law.start()

    def forget(self, state: State, restarted: Bools) -> State:
        return self.law.forget(state, restarted)

    def step(self, state: State, around: Neighborhood, links: LinkGeometry) -> Formed:
        self.last = self.law.step(state, around, links)
        return self.last


def results(what: Scenario) -> Iterator[tuple[State, Formed]]:
    """The law's state and result at each tick, in one crew."""
    world = truth.create(what)
    state, robots = truth.start(world), crew.create(agent_config(what), world.ids)
    law: Any = robots.formation
    recorder = Recorder(law)
    robots = replace(robots, formation=recorder)
    memory, beacons, receiver, present = crew.start(robots), no_beacons(), Receiver(), state.present
    for _ in range(what.ticks):
        if state.present is not present:
            memory = crew.forget(robots, memory, state.present & ~present)
            present = state.present
        observed = truth.observe(state)
        received = receiver.receive(observed, beacons, memory.contacts.edges)
        memory, beacons, twists, _ = crew.step(robots, memory, observed.sensed, received)
        yield memory.formation, recorder.last
        state = truth.step(world, state, truth.held(state, twists))


def mark(state: State, row: int, robot: int) -> Floats:
    """The mark of `robot` for the present period, by the table of a robot."""
    ids, marks = state.table.known(row)
    (found,) = marks[ids == robot]
    return np.array(found)


def test_all_robots_make_the_same_plan_at_the_first_tick_of_a_period() -> None:
    for moment in moments(team(n=10, seconds=4.2)):
        made = [plan for plan in moment.plans.values() if plan is not None]
        assert len(made) == (10 if moment.tick >= 100 else 0)
        assert len({(plan.ids.tobytes(), plan.marks.tobytes(), plan.slots.tobytes()) for plan in made}) <= 1


def test_one_crew_of_n_robots_has_the_digits_of_n_crews_of_one() -> None:
    what = team(n=5, seconds=5.0, run__clock_skew=0.3)
    together, alone = loop.run(what), loop.run(what, split=[[robot] for robot in range(5)])
    assert [a.tobytes() for a in together.poses] == [b.tobytes() for b in alone.poses]
    assert np.abs(together.poses[-1] - together.poses[0]).max() > 1.0  # they moved


def test_the_quality_weight_is_that_of_the_robots_known_and_then_of_the_plan() -> None:
    for tick, (state, formed) in enumerate(results(team(n=10, seconds=2.1))):
        weight = formed.quality_weight
        assert weight is not None
        if tick < 100:
            known = [len(set(state.table.known(row)[0].tolist()) | {row}) for row in range(10)]
            assert weight.tolist() == [shape("lattice", n, 1).quality_weight(1, 1.0) for n in known]
        else:
            assert weight == pytest.approx(np.full(10, 35.0 / 18.0 / 3.8))  # .51170: hops 35/18, neighbors 3.8
    assert formed.details is not None
    assert sorted(formed.details[:, 0].tolist()) == list(range(10))
    assert formed.details[:, 1].tolist() == [planning.DIRECT] * 10


def test_before_the_first_plan_no_robot_is_pulled() -> None:
    for tick, (_, formed) in enumerate(results(team(seconds=2.1))):
        assert formed.pull.any() == (tick >= 100)
        assert formed.details is not None
        assert tick >= 100 or formed.details.tolist() == [[planning.NO_SLOT, planning.NONE]] * 6


def test_no_pull_of_a_plan_is_faster_than_the_limit_and_all_errors_shrink_at_one_rate() -> None:
    for tick, (state, formed) in enumerate(results(team("sparse", 8, 6.0))):
        if tick >= 100:
            # bodies that turn fall behind their predicted marks, from which the longest way is taken
            assert np.hypot(*formed.pull.T).max() <= 5.05
            assert len(set(state.approach.rate.tolist())) == 1


def test_a_formed_team_follows_the_dither_at_the_full_rate() -> None:
    settings = {"seeking__dither_amplitude": 5.0, "seeking__initial_estimate": [71.2, 71.3]}
    patch = 71.26 * shape("lattice", 10, 1).slots
    poses = [(*place, 0.3) for place in patch.tolist()]
    what = scenario("medium", 10, 1, 12.0, "measured", robots__poses=poses, **settings)
    for tick, (state, _) in enumerate(results(what)):
        # The dither moves the outermost robot by up to 7.5 m. Without it in the goals, the longest way would be more
        # than the 5 m at which the limit of speed slows a plan down.
        if tick >= 100:
            assert state.approach.rate.tolist() == [1.0] * 10


def test_a_mark_is_where_its_robot_is_when_the_next_period_begins() -> None:
    previous: State | None = None
    for tick, (state, _) in enumerate(results(team(seconds=12.1))):
        if tick in (300, 400, 500):
            assert previous is not None
            for row in range(6):
                # its next mark, in the frame of its plan, continues the same straight way
                predicted, plan = mark(previous, row, row), state.plans[row]
                assert plan is not None
                assert plan.marks[row].tolist() == predicted[:2].tolist()
        previous = state


def test_a_predicted_mark_is_the_true_position_but_for_the_turn_of_the_body() -> None:
    predicted = np.zeros((6, 2))
    what = team(seconds=12.1)
    states = results(what)
    for moment in moments(what):
        state, _ = next(states)
        if moment.tick in (400, 500, 600):
            assert np.abs(predicted - moment.positions).max() < 0.2  # m; bodies turned in the first period
        if moment.tick % 100 == 0:
            predicted = np.array([mark(state, row, row)[:2] if moment.tick else (0.0, 0.0) for row in range(6)])


def test_a_robot_that_restarts_within_a_period_adopts_its_own_mark() -> None:
    events = [{"at": 6.2, "kill": [2]}, {"at": 6.5, "restart": [2]}]
    marks = {}
    # with one relayed mark in a beacon, its peers need some ticks to tell it its own mark
    what = team(n=6, seconds=8.2, event=events, formation__marks_per_beacon=1)
    for tick, (state, _) in enumerate(results(what)):
        if tick == 305:
            marks[tick] = mark(state, 2, 2)
        if tick == 326:
            assert 2 not in state.table.known(2)[0]  # it has forgotten, and listens
        if tick == 399:
            assert mark(state, 2, 2).tolist() == marks[305].tolist()
            assert all(mark(state, row, 2).tolist() == marks[305].tolist() for row in range(6))
    plans = {(plan.ids.tobytes(), plan.marks.tobytes()) for plan in state.plans if plan is not None}
    assert len(plans) == 1
    assert state.approach.kind.tolist() == [planning.DIRECT] * 6


def test_a_robot_that_joins_marks_in_the_present_period_and_is_in_the_next_plan() -> None:
    events = [{"at": 0.0, "kill": [2]}, {"at": 6.4, "restart": [2]}]
    for tick, (state, _) in enumerate(results(team(n=6, seconds=8.1, event=events))):
        if tick < 400:
            knows = 2 in state.table.known(0)[0]
            assert knows == (tick >= 345) or 320 <= tick < 345  # it listens for 11 ticks after it heard them
        if tick == 399:
            assert state.plans[0] is not None
            assert state.plans[0].ids.tolist() == [0, 1, 3, 4, 5]
    assert all(plan is not None and plan.ids.tolist() == list(range(6)) for plan in state.plans)


def test_a_dead_robot_is_in_no_plan_after_the_next_period() -> None:
    *_, (state, _) = results(team(n=6, seconds=10.1, event=[{"at": 5.5, "kill": [2]}]))
    others = [plan for row, plan in enumerate(state.plans) if row != 2]
    assert all(plan is not None and plan.ids.tolist() == [0, 1, 3, 4, 5] for plan in others)


def test_a_formed_team_that_loses_a_robot_forms_again() -> None:
    # n = 8 to 7: a hexagon around one robot
    poses = [(*place, 0.3) for place in (spacing(team(n=8), 8) * shape("lattice", 8, 1).slots).tolist()]
    outcome = watch(team(n=8, seconds=24.0, robots__poses=poses, event=[{"at": 4.1, "kill": [0]}]), 10)
    assert outcome.settled(0.99, after=4.1) < 18.0
    assert (outcome.cut, outcome.differing, outcome.contracted) == (0, 0, 0)


@pytest.mark.parametrize("skew", [0.05, 0.5])
def test_robots_whose_clocks_differ_make_the_same_plans(skew: float) -> None:
    outcome = watch(team("sparse", 6, 8.0, run__clock_skew=skew), 100)
    assert (outcome.cut, outcome.differing) == (0, 0)
    assert outcome.path.max() > 20.0  # m; they moved


def test_a_clock_that_is_set_back_or_ahead_costs_no_agreement_for_long() -> None:
    events = [{"at": 3.9, "clock": {"robot": 1, "skew": 0.3}}, {"at": 6.1, "clock": {"robot": 1, "skew": -0.3}}]
    outcome = watch(team(n=6, seconds=12.0, event=events), 100)
    assert outcome.cut == 0
    for moment in moments(team(n=6, seconds=12.0, event=events)):
        last = moment
    assert len({plan.marks.tobytes() for plan in last.plans.values() if plan is not None}) == 1


def test_the_papers_start_takes_up_the_patch_in_20_seconds() -> None:
    outcome = watch(scenario("paper", 10, 1, 25.5))
    assert (outcome.cut, outcome.differing, outcome.contracted) == (0, 0, 0)
    assert outcome.least == pytest.approx(25.0, abs=0.05)
    assert outcome.settled(0.97) == pytest.approx(19.0, abs=0.5)
    assert outcome.settled(0.99) == pytest.approx(20.0, abs=0.5)
    assert outcome.path.max() == pytest.approx(84.0, abs=1.5)


def test_the_state_is_a_value_that_a_step_does_not_change() -> None:

    before: list[tuple[bytes, State]] = []
    for tick, (state, _) in enumerate(results(team(n=4, seconds=2.4))):
        if tick in (10, 50, 99, 100, 101):
            before.append((pickle.dumps(state), state))
    assert all(pickle.dumps(state) == data for data, state in before)
    assert pickle.loads(before[-1][0]).table.marks.tolist() == before[-1][1].table.marks.tolist()
