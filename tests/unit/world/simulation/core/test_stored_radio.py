"""A radio in a buffer of the core behaves like any other: its arrays, copies, changes and pickles."""

import copy
import pickle
from dataclasses import fields, replace

import numpy as np
import pytest

from tests.support import bits, cores
from tests.support.loop import load
from world.simulation import truth
from world.simulation.channel import Radio
from world.simulation.core import compiled_world
from world.simulation.core.stored_radio import StoredRadio
from world.simulation.truth import State

pytestmark = cores.needs(compiled_world.load())


def after(ticks: int) -> State:
    """The state of the paper's robots after some ticks of standing still."""
    world = truth.create(load("paper.toml"))
    state = truth.start(world)
    for _ in range(ticks):
        state = truth.step(world, state, np.zeros((10, 2)))
    return state


def arrays(radio: Radio) -> dict[str, object]:
    return {field.name: getattr(radio, field.name) for field in fields(Radio) if field.name != "edges"}


def test_an_array_is_made_once_and_only_when_it_is_read() -> None:
    radio = after(5).radio
    assert isinstance(radio, StoredRadio)
    assert "sent" not in vars(radio)
    assert radio.sent is radio.sent
    assert radio.sent.tolist() == [4] * len(radio.edges)


def test_copies_and_pickles_are_plain_radios_with_the_same_arrays() -> None:
    radio = after(5).radio
    for other in (pickle.loads(pickle.dumps(radio)), copy.deepcopy(radio)):
        assert type(other) is Radio
        assert not bits.differences(arrays(other), arrays(radio))


def test_a_radio_with_another_field_keeps_the_rest() -> None:
    radio = after(5).radio
    changed = replace(radio, age=radio.age + 1)
    assert not bits.differences(arrays(changed), {**arrays(radio), "age": radio.age + 1})


def test_a_radio_is_not_changed() -> None:
    with pytest.raises(AttributeError):
        after(2).radio.sent = np.zeros(1, dtype=np.int64)  # type: ignore[misc]
