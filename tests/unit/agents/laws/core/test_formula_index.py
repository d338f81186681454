"""The compiled index of the channel's formula repeats numpy to the bit, with its slope and its bend."""

import ctypes
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from agents.laws import oracle
from agents.laws.core import formula_index
from agents.laws.oracle import FormulaIndex
from fes.arrays.types import Floats
from fes.extension.told_channel import ToldChannel
from fes.model.config import ChannelConfig, ObjectiveConfig
from fes.model.seeking import OracleConfig
from tests.support import bits, cores, laws

LIBRARY = formula_index.load()
pytestmark = cores.needs(LIBRARY)

CHANNELS: dict[str, dict[str, Any]] = {
    "rayleigh": {},
    "exponent 2.7": {"path_loss_exponent": 2.7},
    "weak": {"reference_snr": 1e3, "path_loss_exponent": 4.0},
    "perfect": {"model": "perfect"},
    "logistic": {"model": "logistic"},
    "steep": {"model": "logistic", "logistic_width": 0.5},
}
SHAPES = (4.0, 3.3, 2.0, 1.5)


@pytest.fixture(autouse=True)
def _quiet() -> Iterator[None]:
    with np.errstate(all="ignore"):
        yield


def separations(count: int) -> Floats:
    generator = np.random.default_rng(count)
    usual = bits.sprinkled(generator, generator.uniform(-5.0, 300.0, count), 0.05)
    wide = np.ldexp(generator.uniform(-1.0, 1.0, 500), generator.integers(-900, 900, 500))
    return np.concatenate([usual, bits.SPECIAL, wide])


def compiled(index: FormulaIndex, separation: Floats, with_slope: bool) -> list[Floats]:
    """Results of the library: the value, and perhaps the slope, the bend and the trusted length."""
    found = formula_index.compiled(index.settings)
    assert found is not None
    address, settings = found
    call = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_int64, *[ctypes.c_void_p] * 5)(address)
    results = [np.full_like(separation, 7.0) for _ in range(4)]
    rows = [row.ctypes.data if with_slope or row is results[0] else None for row in results]
    call(ctypes.addressof(settings), len(separation), separation.ctypes.data, *rows)
    return results if with_slope else results[:1]


@pytest.mark.parametrize("transform", ["log", "none"])
@pytest.mark.parametrize("channel", CHANNELS)
def test_the_index_repeats_numpy(channel: str, transform: Any) -> None:
    for shape in SHAPES:
        index = FormulaIndex(ObjectiveConfig(shape_exponent=shape), ChannelConfig(**CHANNELS[channel]), transform)
        for count in (4000, 64, 65, 1, 0):
            separation = separations(count)[: count or None]
            assert not bits.differences(compiled(index, separation, False)[0], index(separation))
            numpy = *index.parabola(separation), index.trusted(separation)
            for ours, theirs in zip(compiled(index, separation, True), numpy, strict=True):
                assert not bits.differences(ours, theirs)


def test_only_the_oracle_itself_has_a_compiled_index() -> None:
    class Derived(oracle.OracleSeeking):
        """A law of somebody else."""

    context = laws.context(np.arange(3), ChannelConfig())
    assert isinstance(context.channel, ToldChannel)
    parameters = OracleConfig()
    assert oracle.OracleSeeking(parameters, context).compiled_index() is not None
    assert Derived(parameters, context).compiled_index() is None
