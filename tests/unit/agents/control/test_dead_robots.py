"""Robots that die and rejoin: the view of their peers, and that a robot that rejoins is a new process."""

from typing import Any

import numpy as np
import pytest

from agents.control import crew as crews
from agents.runtime.reception import Receiver
from console.backends import inprocess
from fes.errors import ScenarioError
from fes.model.sensing import CLOSED, DECODED, LOST, no_beacons
from tests.support import loop
from tests.support.loop import load
from tests.support.results import contract_digest
from world.config.scenario import Scenario, agent_config
from world.metrics import report_builder
from world.metrics.collector import MetricsCollector
from world.simulation import truth

GONE: list[dict[str, Any]] = [{"at": 1.0, "kill": [4, 6]}, {"at": 2.4, "restart": [4]}, {"at": 2.6, "restart": [6]}]
BRIEF = {"run__duration": 4, "formation__contact_timeout": 0.5}


def with_new_processes(what: Scenario) -> str:
    """The digest of a run with one crew per robot, where a robot that rejoins starts without state."""
    world = truth.create(what)
    state = truth.start(world)
    config, ids = agent_config(what), world.ids.tolist()
    parts = [crews.create(config, np.array([robot])) for robot in ids]
    minds, said = [crews.start(part) for part in parts], [no_beacons()] * len(ids)
    receivers = [Receiver() for _ in parts]
    ticks, present = [], state.present
    for _ in range(what.ticks):
        for robot in np.flatnonzero(state.present & ~present).tolist():
            minds[robot], receivers[robot] = crews.start(parts[robot]), Receiver()
        present, sensed = state.present, truth.observe(state)
        heard = loop._together(said) if said[0].tick >= 0 else said[0]
        twists, told = np.zeros((len(ids), 2)), list(said)
        for robot in np.flatnonzero(present).tolist():
            own = loop._own(sensed, parts[robot].ids)
            near = loop._among(heard, np.unique(own.in_range.peers)) if heard.tick >= 0 else heard
            stepped = loop.tick(parts[robot], minds[robot], receivers[robot], own, near)
            minds[robot], told[robot], twists[robot], _ = stepped
        said = [part if part.tick == state.tick else _again(part, state.tick) for part in told]
        ticks.append((state.poses, twists))
        state = truth.step(world, state, twists)
    return contract_digest(ticks)


def _again(beacons: Any, tick: int) -> Any:
    """An old beacon with a new date: no robot may use it, since the radio lost it."""
    return beacons._replace(tick=tick)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "settings"),
    [
        ("paper.toml", {}),
        ("measured.toml", {"seeking__pooling": "network"}),
        ("measured.toml", {"seeking__pooling": "none"}),
    ],
)
def test_a_robot_that_rejoins_acts_like_a_new_process(name: str, settings: dict[str, Any]) -> None:
    scenario = load(name, event=GONE, **settings, **BRIEF)
    assert inprocess.run(scenario, name)["digest"] == with_new_processes(scenario)


def test_a_dead_robot_stands_still_and_silent_and_its_contacts_reopen_when_it_rejoins() -> None:
    gone = [{"at": 4.0, "kill": [4]}, {"at": 8.0, "restart": [4]}]
    scenario = load("neighborhood.toml", run__duration=9.5, event=gone)
    poses, codes = [], []
    for tick in inprocess.ticks(scenario):
        radio = tick.state.radio
        poses.append(tick.state.poses[4])
        positions = radio.edges.find(radio.edges.key(np.array([2, 4]), np.array([4, 2])))
        codes.append(radio.reception[positions].tolist() if (positions >= 0).all() else None)
        if 200 <= tick.state.tick < 400:
            assert tick.twists[4].tolist() == [0.0, 0.0]
            assert 4 not in tick.telemetry.links.rows
        elif tick.state.tick > 450:
            assert tick.twists[4].any()
    assert all(pose.tolist() == poses[200].tolist() for pose in poses[200:401])
    assert DECODED in [code for pair in codes[100:200] if pair for code in pair]
    # the beacons of tick 199 were sent; those of 200 to 399 were not
    assert {code for pair in codes[201:400] if pair for code in pair} == {LOST}
    assert codes[400] == codes[401] == [CLOSED, CLOSED]
    assert DECODED in [code for pair in codes[402:420] if pair for code in pair]


def test_links_of_a_dead_robot_expire_and_it_resumes_from_its_peers_estimates() -> None:
    scenario = load(
        "neighborhood.toml", run__duration=12, event=[{"at": 6.0, "kill": [4]}, {"at": 9.0, "restart": [4]}]
    )
    linked, first = [], None
    for tick in inprocess.ticks(scenario):
        links = tick.telemetry.links
        linked.append(4 in links.peers)
        mine = tick.telemetry.estimates[links.rows == 4]
        if tick.state.tick >= 450 and len(mine) and first is None:
            first = mine.tolist()
    timeout = round(scenario.formation.contact_timeout / scenario.run.dt)
    assert all(linked[250 : 300 + timeout - 5])
    assert not any(linked[300 + timeout + 2 : 450])
    assert any(linked[455:])
    assert first is not None
    assert first == pytest.approx([68.114] * len(first), abs=0.1)  # settled after 9 s; a draw would be from 50 to 90


def test_links_count_as_connected_among_those_that_are_present() -> None:
    alone = load("pair.toml", run__duration=6, event=[{"at": 3.0, "kill": [1]}])
    assert inprocess.run(alone, "pair")["links_connected_always"]
    middle = load("neighborhood.toml", run__duration=8, event=[{"at": 4.0, "kill": [4]}])
    assert not inprocess.run(middle, "gap")["links_connected_always"]  # until the links have re-formed


@pytest.mark.parametrize(
    ("events", "rule"),
    [
        ([{"at": 1.0, "kill": [10]}], "kill: robot 10 does not exist: there are only 10"),
        ([{"at": 1.0, "restart": [1]}], "restart: robot 1 is alive already at 1 s"),
        ([{"at": 1.0, "kill": [1]}, {"at": 2.0, "kill": [1]}], "kill: robot 1 is dead already at 2 s"),
        ([{"at": 1.0}], "give at least one of set, kill, restart, hang, wake, transmitter, clock and world_away"),
        ([{"at": 1.0, "kill": [1], "restart": [1]}], "robot 1 must be named once, but is in kill and in restart"),
    ],
)
def test_an_impossible_death_is_rejected_in_one_line(events: list[dict[str, Any]], rule: str) -> None:
    with pytest.raises(ScenarioError, match=rule):
        load("paper.toml", event=events)


def test_a_report_shows_participating_robots_as_alive_and_waiting_agents_not() -> None:
    scenario = load("pair.toml", run__duration=0.4, event=[{"at": 0.2, "kill": [1]}])
    metrics, shown = MetricsCollector(scenario), []
    for tick in inprocess.ticks(scenario):
        metrics.add(tick.state, tick.twists, tick.telemetry)
        shown.append(report_builder.build(metrics, "test", np.ones(2, dtype=np.uint8), 0.0, 0.0).alive.tolist())
    assert shown == [[1, 1]] * 10 + [[1, 0]] * 10
