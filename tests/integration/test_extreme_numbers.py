"""Numbers that a robot may publish, however large, break no peer, no world and no viewer."""

from typing import Any

import numpy as np
import pytest

from agents.control import crew
from agents.runtime import marshalling as agent_marshalling
from agents.runtime.marshalling import MessageAssembler
from agents.runtime.reception import Receiver
from fes.arrays.types import Floats
from fes.errors import MessageError
from fes.model.sensing import MAX_NUMBER, MAX_TWIST, Beacons, bounded, no_beacons
from fes.protocol import keys, messages
from fes.protocol.messages import Beacon, Command
from fes.protocol.report import decode_report, encode_report
from tests.support import loop
from tests.support.loop import load
from world.config.scenario import agent_config
from world.execution import marshalling as world_marshalling
from world.execution.run import Answer, Run
from world.metrics import report_builder, summary
from world.metrics.collector import MetricsCollector
from world.simulation import truth

HOSTILE, FIRST, TICKS = 4, 40, 90
ALIVE = np.ones(10, dtype=np.uint8)
LAWS: dict[str, tuple[str, dict[str, Any]]] = {
    "corrected": ("paper.toml", {}),
    "printed": ("paper-as-printed.toml", {}),
    "log index": ("neighborhood.toml", {}),
    "measured": ("measured.toml", {}),
    "measured by links": ("measured.toml", {"seeking__pooling": "none"}),
    "sampled": ("measured.toml", {"seeking__index": "sampled", "seeking__index_transform": "none"}),
}
EXTREMES = [MAX_NUMBER, -MAX_NUMBER, 1e6, 0.0, -5.0, 5e-324]


def falsified(said: Beacons, field: str, value: float) -> Beacons:
    """The beacons of a tick, with one field of the hostile robot's beacon replaced."""
    poses, estimates, statistics = said.poses.copy(), said.estimates.copy(), said.statistics.copy()
    if field == "poses":
        poses[HOSTILE] = value
    elif field == "estimates":
        estimates[said.links.rows == HOSTILE] = value
    else:
        statistics[HOSTILE] = value
    return said._replace(poses=poses, estimates=estimates, statistics=statistics)


CASES = [(law, field) for law in LAWS for field in ("poses", "estimates")] + [("measured", "statistics")]


@pytest.mark.parametrize("value", EXTREMES)
@pytest.mark.parametrize(("law", "field"), CASES)
def test_no_number_in_a_beacon_leaves_a_peer_without_a_twist(law: str, field: str, value: float) -> None:
    """crew.step raises if a twist is not finite, and numpy's warnings are errors here."""
    name, settings = LAWS[law]
    scenario = load(name, **settings)
    world = truth.create(scenario)
    state, robots = truth.start(world), crew.create(agent_config(scenario), world.ids)
    minds, said, receiver = crew.start(robots), no_beacons(), Receiver()
    for tick in range(TICKS):
        minds, said, twists, _ = loop.tick(robots, minds, receiver, truth.observe(state), said)
        assert np.abs(twists).max() <= MAX_TWIST
        if tick >= FIRST:
            said = falsified(said, field, value)
        state = truth.step(world, state, twists)


def some(choose: np.random.Generator, count: int) -> Floats:
    return choose.choice(np.array([0.0, MAX_NUMBER, -MAX_NUMBER, 5e-324, 1.0, -70.0, 70.0]), size=count)


def any_beacon(choose: np.random.Generator, tick: int, statistics: int) -> bytes:
    """A valid beacon of the hostile robot, possibly with links to itself and to unknown robots."""
    links = np.sort(choose.choice(20, size=choose.integers(10), replace=False))
    named = choose.integers(0, 2, len(links)).astype(np.uint8)
    numbers = some(choose, len(links)), named, some(choose, int(choose.choice([0, statistics, 7])))
    return messages.encode_beacon(Beacon(tick, HOSTILE, (*some(choose, 2).tolist(), 0.5), links, *numbers))


def any_command(choose: np.random.Generator, tick: int) -> bytes:
    """A valid command of the hostile robot."""
    links = np.sort(choose.choice(10, size=choose.integers(10), replace=False))
    numbers = some(choose, len(links)), some(choose, int(choose.choice([0, 2 * len(links)])))
    return messages.encode_command(Command(tick, HOSTILE, (1.0, 0.5), links, *numbers))


@pytest.mark.parametrize("law", ["corrected", "log index", "measured"])
@pytest.mark.parametrize("seed", range(8))
def test_no_valid_beacon_or_command_stops_a_peer_or_the_world(law: str, seed: int) -> None:
    """25 ticks of such messages, encoded and decoded, with all steps of the world on them."""
    choose, (name, settings) = np.random.default_rng(seed), LAWS[law]
    scenario = load(name, run__duration=0.9, run__seed=seed, **settings)
    run, stack = Run(scenario), MessageAssembler(np.arange(10))
    robots = crew.create(agent_config(scenario), run.world.ids)
    minds, heard, receiver = crew.start(robots), no_beacons(), Receiver()
    while not run.is_over:
        tick, sent = run.state.tick, run.observations(run.state.present)
        sensed = truth.observe(run.state)
        minds, beacons, twists, telemetry = loop.tick(robots, minds, receiver, sensed, heard)
        spoken = [[beacon, order] for _, beacon, order in agent_marshalling.encode_tick(beacons, twists, telemetry)]
        if tick >= 20:
            spoken[HOSTILE] = [any_beacon(choose, tick, robots.seeking.statistics), any_command(choose, tick)]
        heard = stack.beacons(tick, [messages.decode_beacon(beacon) for beacon, _ in spoken])
        answers: list[Answer | None] = [
            (world_marshalling.decode(keys.command("r", i), order, 10), order) for i, (_, order) in enumerate(spoken)
        ]
        run.advance(sent, answers, [beacon for beacon, _ in spoken], ALIVE, 0.1)
        run.record_tick()
        decode_report(encode_report(report_builder.build(run.metrics, "test", ALIVE, 0.0, 0.0)))
    assert summary.summarize(run.metrics, "test", "test", 1.0)["ticks"] == scenario.ticks


@pytest.mark.parametrize("twist", [[MAX_TWIST, 0.0], [-MAX_TWIST, MAX_TWIST], [0.0, -MAX_TWIST]])
def test_no_command_makes_a_pose_or_a_report_that_is_not_finite(twist: list[float]) -> None:
    scenario = load("measured.toml", run__duration=4.0)
    world, metrics = truth.create(scenario), MetricsCollector(scenario)
    state, robots = truth.start(world), crew.create(agent_config(scenario), world.ids)
    minds, beacons, receiver = crew.start(robots), no_beacons(), Receiver()
    for tick in range(scenario.ticks):
        sensed = truth.observe(state)
        minds, beacons, twists, telemetry = loop.tick(robots, minds, receiver, sensed, beacons)
        if tick >= FIRST:
            twists[HOSTILE] = twist
        metrics.add(state, twists, telemetry)
        state = truth.step(world, state, twists)
    assert np.isfinite(state.poses).all()
    report = report_builder.build(metrics, "test", ALIVE, 0.0, 0.0)
    assert np.array_equal(decode_report(encode_report(report)).poses, report.poses)


LINK, ONE = np.array([1]), np.ones(1, dtype=np.uint8)
BEYOND = 1.0001


def beacon(x: float = 0.0, estimate: float = 0.0, statistic: float = 0.0) -> bytes:
    numbers = np.array([estimate]), ONE, np.array([statistic])
    return messages.encode_beacon(Beacon(3, 0, (x, 0.0, 0.0), LINK, *numbers))


def command(linear: float = 0.0, angular: float = 0.0, estimate: float = 0.0) -> bytes:
    return messages.encode_command(Command(3, 0, (linear, angular), LINK, np.array([estimate]), np.zeros(0)))


@pytest.mark.parametrize("field", ["x", "estimate", "statistic"])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_beacon_holds_numbers_up_to_a_bound(field: str, sign: float) -> None:
    messages.decode_beacon(beacon(**{field: sign * MAX_NUMBER}))
    with pytest.raises(MessageError, match=r"Beacon: (expects a number|numbers must be) within 1e\+12 of zero"):
        messages.decode_beacon(beacon(**{field: sign * MAX_NUMBER * BEYOND}))


@pytest.mark.parametrize(("field", "most"), [("linear", MAX_TWIST), ("angular", MAX_TWIST), ("estimate", MAX_NUMBER)])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_command_holds_numbers_up_to_a_bound(field: str, most: float, sign: float) -> None:
    messages.decode_command(command(**{field: sign * most}))
    with pytest.raises(MessageError, match=r"Command: (expects a number|numbers must be) within 1e\+\d+ of zero"):
        messages.decode_command(command(**{field: sign * most * BEYOND}))


def test_bounded_keeps_values_within_the_bounds_to_the_bit() -> None:
    values = np.array([-0.0, 0.0, 1.5, -3e11, MAX_NUMBER, 2e12, -2e12, np.inf, -np.inf, np.nan])
    result = bounded(values, MAX_NUMBER)
    assert result[:5].tobytes() == values[:5].tobytes()
    assert result[5:9].tolist() == [MAX_NUMBER, -MAX_NUMBER, MAX_NUMBER, -MAX_NUMBER]
    assert np.isnan(result[9])
