"""An agent's tick from bytes to bytes: the bytes are those by way of arrays, and junk is left to Python."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from agents.control import crew as crews
from agents.core import byte_crew, compiled_crew
from agents.core.byte_crew import ByteCrew
from agents.runtime import marshalling
from agents.runtime.crew_run import CrewRun
from agents.runtime.marshalling import MessageAssembler
from fes.arrays.types import Ints
from fes.errors import MessageError
from fes.protocol import messages, wire
from tests.support import cores, loop
from world.config.scenario import agent_config
from world.execution import marshalling as world_marshalling
from world.simulation import truth
from world.simulation.truth import State, World

pytestmark = cores.needs(compiled_crew.load())

Payloads = list[tuple[int, bytes, bytes]]


@pytest.fixture(autouse=True)
def _quiet() -> Iterator[None]:
    with np.errstate(all="ignore"):
        yield


def world_of(name: str, **overrides: Any) -> World:
    """The world of a scenario."""
    return truth.create(loop.load(f"{name}.toml", **overrides))


class Process:
    """Some robots of a run, moved by bytes, and once more by way of arrays."""

    def __init__(self, world: World, ids: Ints) -> None:
        config = agent_config(world.scenario)
        self.ids = ids
        self.compiled = compiled_crew.of(crews.create(config, ids))
        assert self.compiled is not None
        self.bytes = ByteCrew(self.compiled, wire.PROTOCOL)
        self.arrays, self.assembler = CrewRun(crews.create(config, ids)), MessageAssembler(ids)
        self.since = np.zeros(len(ids), np.int64)

    def by_bytes(self, tick: int, observations: list[bytes], beacons: list[bytes]) -> Payloads | None:
        """The answers of the core."""
        return self.bytes.step(tick, observations, beacons, self.since, is_model_free=True)

    def by_arrays(self, observations: list[bytes], beacons: list[bytes]) -> Payloads:
        """The answers by way of messages and arrays; raises MessageError."""
        sensed = self.assembler.observations([messages.decode_observation(payload) for payload in observations])
        heard = self.assembler.beacons(sensed.tick - 1, [messages.decode_beacon(payload) for payload in beacons])
        sent, twists, telemetry = self.arrays.step(sensed, heard)
        return marshalling.encode_tick(sent, twists, telemetry._replace(is_model_free=True))


def inputs(state: State, ids: Ints, beacons: list[bytes]) -> tuple[list[bytes], list[bytes]]:
    """The observations of some robots, and the beacons of all peers in range of one of them."""
    present = np.ones(len(state.poses), np.bool_)
    payloads = world_marshalling.observations(truth.observe(state), present, state.since)
    edges = state.radio.edges
    peers = np.unique(edges.peers[np.isin(edges.robots, ids)]).tolist()
    return [payloads[robot] for robot in ids.tolist()], [beacons[peer] for peer in peers if beacons[peer]]


def run(
    world: World, processes: list[Process], ticks: int
) -> Iterator[tuple[Process, int, list[bytes], list[bytes]]]:
    """Each process at each tick, with its messages; the answers by way of arrays move the world."""
    state, beacons = truth.start(world), [b""] * len(world.ids)
    for tick in range(ticks):
        sent, twists = [b""] * len(beacons), np.zeros((len(beacons), 2))
        for process in processes:
            observed, heard = inputs(state, process.ids, beacons)
            yield process, tick, observed, heard
            expected = process.by_arrays(observed, heard)
            assert process.by_bytes(tick, observed, heard) == expected
            for robot, beacon, command in expected:
                sent[robot], twists[robot] = beacon, messages.decode_command(command).twist
        state, beacons = truth.step(world, state, twists), sent


@pytest.mark.parametrize(
    ("scenario", "overrides"),
    [
        ("paper", {}),
        ("measured", {}),
        ("measured", {"seeking__pooling": "none"}),
        ("paper", {"seeking__index": "sampled"}),
        ("paper", {"run__clock_skew": 0.05}),
    ],
)
@pytest.mark.parametrize("size", [1, 4])
def test_answers_are_those_by_way_of_arrays(scenario: str, overrides: dict[str, Any], size: int) -> None:
    world = world_of(scenario, **overrides)
    groups = np.split(world.ids, list(range(size, 10, size)))
    processes = [Process(world, group) for group in groups]
    for process, *_ in run(world, processes, 60):
        assert process.bytes.peers <= set(world.ids.tolist())
    for process in processes:
        assert process.compiled is not None
        assert process.bytes.peers


def test_room_grows_for_more_peers_than_at_first() -> None:
    robots = byte_crew.ROOM + 8
    world = world_of("hundred", robots__count=robots, robots__spacing=5.0)
    for _ in run(world, [Process(world, world.ids[:2]), Process(world, world.ids[2:])], 4):
        pass


@pytest.mark.parametrize("seed", range(2))
def test_a_damaged_message_is_left_to_python_or_means_the_same_to_both(seed: int) -> None:
    generator = np.random.default_rng(seed)
    world = world_of("measured" if seed % 2 else "paper")
    process = Process(world, world.ids[:1])
    others = Process(world, world.ids[1:])
    counts = {"left": 0, "answered": 0}
    for one, tick, observed, heard in run(world, [process, others], 30):
        if one is not process:
            continue
        for _ in range(20):
            damaged_observed, damaged_heard = damaged(generator, observed, heard)
            trial = Process(world, process.ids)
            assert process.compiled is not None
            assert trial.compiled is not None
            trial.compiled.state = trial.arrays.compiled.state = process.compiled.state  # type: ignore[union-attr]
            answers = trial.by_bytes(tick, damaged_observed, damaged_heard)
            if answers is None:
                counts["left"] += 1
                continue
            counts["answered"] += 1
            try:
                assert trial.by_arrays(damaged_observed, damaged_heard) == answers
            except MessageError as error:
                pytest.fail(f"the core read a message that Python rejects: {error}")
    assert min(counts.values()) > 10, counts


def damaged(
    generator: np.random.Generator, observed: list[bytes], heard: list[bytes]
) -> tuple[list[bytes], list[bytes]]:
    """The messages with one of them damaged: a flipped bit, a cut, more bytes, or bytes of another message."""
    everything = [*observed, *heard]
    place = int(generator.integers(len(everything)))
    data = bytearray(everything[place])
    kind, where = int(generator.integers(5)), int(generator.integers(len(data)))
    if kind == 0:
        data[where] ^= 1 << int(generator.integers(8))
    elif kind == 1:
        del data[where:]
    elif kind == 2:
        data += generator.bytes(int(generator.integers(1, 9)))
    elif kind == 3:
        data[where : where + 8] = generator.bytes(8)
    else:
        data = bytearray(everything[int(generator.integers(len(everything)))])
    everything[place] = bytes(data)
    return everything[: len(observed)], everything[len(observed) :]


def test_a_beacon_with_too_many_links_is_left_to_python_and_takes_no_memory() -> None:
    world = world_of("pair")
    process, other = Process(world, world.ids[:1]), Process(world, world.ids[1:])
    length = None
    for one, tick, observed, heard in run(world, [process, other], 6):
        if one is not process or not heard:
            continue
        links = np.arange(byte_crew.LINKS * 100)
        own = messages.decode_beacon(heard[0])
        many = own._replace(links=links, estimates=np.zeros(len(links)), selected=np.zeros(len(links), np.uint8))
        before = process.compiled
        assert before is not None
        assert process.by_bytes(tick, observed, [messages.encode_beacon(many)]) is None
        length = length or len(before.stored.buffer)
        assert len(before.stored.buffer) == length
    assert length is not None


def test_a_fix_of_another_tick_is_left_to_python() -> None:
    world = world_of("measured")
    process, others = Process(world, world.ids[:3]), Process(world, world.ids[3:])
    for one, tick, observed, heard in run(world, [process, others], 8):
        if one is process and tick > 0:
            held = messages.decode_observation(observed[1])._replace(fixed=tick - 1)
            assert held.robot == 1
            given_ = [observed[0], messages.encode_observation(held), observed[2]]
            assert process.by_bytes(tick, given_, heard) is None
