"""The messages of a tick as the compiled core packs them: byte for byte those that numpy and msgpack make."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from agents.core import compiled_crew
from agents.core.compiled_crew import CompiledCrew, Failed, Sent
from console.backends import inprocess
from console.backends.inprocess import Tick
from fes.model.sensing import Beacons, Observations
from fes.recording.layout import PackedPayloads, TickPayloads
from tests.support import cores, loop
from world.config.scenario import Scenario

pytestmark = cores.needs(compiled_crew.load())

TICKS = 150

ABSENT = [{"at": 0.4, "kill": [0, 3]}, {"at": 1.0, "restart": [3]}, {"at": 2.0, "restart": [0]}]
DAMAGED = [
    {"at": 0.5, "transmitter": {"robot": 4, "corrupt": True}},
    {"at": 0.7, "hang": [5]},
    {"at": 1.5, "transmitter": {"robot": 4}},
]
CHANGED = [{"at": 1.2, "set": {"channel.communication_range": 60.0}}]


@pytest.fixture(autouse=True)
def _quiet() -> Iterator[None]:
    with np.errstate(all="ignore"):
        yield


def scenario(name: str, **overrides: Any) -> Scenario:
    """The first ticks of a scenario."""
    return loop.load(f"{name}.toml", **{"run__duration": 3.0, **overrides})


@pytest.mark.parametrize(
    ("name", "overrides"),
    [
        ("pair", {}),
        ("paper", {}),
        ("paper", {"event": ABSENT}),
        ("paper", {"event": [*ABSENT, *CHANGED]}),
        ("paper", {"event": DAMAGED}),
        ("paper", {"seeking__index": "sampled"}),
        ("paper", {"run__clock_skew": 0.05}),
        ("measured", {}),
        ("measured", {"event": ABSENT}),
        ("measured", {"seeking__pooling": "none", "event": DAMAGED}),
        ("hundred", {"run__duration": 0.4}),
    ],
)
def test_the_core_packs_the_bytes_of_the_messages(name: str, overrides: dict[str, Any]) -> None:
    ticks = 0
    for tick in inprocess.ticks(scenario(name, **overrides)):
        packed = inprocess.packed(tick)
        assert isinstance(packed, PackedPayloads)
        assert packed.unpacked() == inprocess.payloads(tick)
        ticks += 1
    assert ticks > 10


def test_absent_robots_and_damaged_beacons_have_empty_messages() -> None:
    seen = set()
    for tick in inprocess.ticks(scenario("paper", event=[*ABSENT[:1], *DAMAGED])):
        packed = inprocess.packed(tick)
        assert isinstance(packed, PackedPayloads)
        seen |= {
            (robot, *map(bool, payloads)) for robot, *payloads in zip(range(10), *packed.unpacked(), strict=True)
        }
    assert (0, False, False, False) in seen
    assert (4, True, False, True) in seen
    assert (5, False, False, False) in seen
    assert (4, False, False, False) not in seen


def test_an_earlier_tick_has_its_own_messages() -> None:
    ticks = list(inprocess.ticks(scenario("paper", run__duration=0.2)))
    assert isinstance(inprocess.packed(ticks[-1]), PackedPayloads)
    for tick in ticks[:-1]:
        assert inprocess.packed(tick) == inprocess.payloads(tick)


@pytest.mark.parametrize("overrides", [{"event": [{"at": 0.5, "transmitter": {"robot": 2, "delay": 0.1}}]}])
def test_messages_of_a_crew_that_numpy_moves_are_made_one_by_one(overrides: dict[str, Any]) -> None:
    ticks: Iterator[Tick] = inprocess.ticks(scenario("paper", **overrides))
    assert all(inprocess.packed(tick) == inprocess.payloads(tick) for tick in ticks)


def test_a_crew_whose_tick_failed_is_packed_by_numpy_from_then_on(monkeypatch: pytest.MonkeyPatch) -> None:
    step, numbers = CompiledCrew.step, iter(range(TICKS))

    def failing(crew: CompiledCrew, observations: Observations, beacons: Beacons) -> Sent:
        if next(numbers) == 10:
            raise Failed
        return step(crew, observations, beacons)

    monkeypatch.setattr(CompiledCrew, "step", failing)
    kinds = []
    for tick in inprocess.ticks(scenario("paper", run__duration=0.4)):
        packed = inprocess.packed(tick)
        kinds.append(type(packed))
        unpacked = packed.unpacked() if isinstance(packed, PackedPayloads) else packed
        assert unpacked == inprocess.payloads(tick)
    assert kinds == [PackedPayloads] * 10 + [TickPayloads] * 10
