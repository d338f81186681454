"""The radio of a tick in a buffer of the compiled core: each of its arrays is made when it is first read."""

from dataclasses import fields
from typing import Any

from numpy.typing import NDArray

from fes.arithmetic.core.library import Buffer
from fes.arrays.edges import Edges
from world.simulation.channel import Radio
from world.simulation.core.structures import LEDGER, Layout


class StoredRadio(Radio):
    """A Radio whose arrays lie in a buffer. Most ticks read two of its nine arrays."""

    _layout: Layout
    _buffer: Buffer

    @staticmethod
    def of(edges: Edges, layout: Layout, buffer: Buffer) -> "StoredRadio":
        """The radio over the pairs `edges` in a buffer of this layout."""
        radio = object.__new__(StoredRadio)
        vars(radio).update(edges=edges, _layout=layout, _buffer=buffer)
        return radio

    def __reduce__(self) -> tuple[type[Radio], tuple[Any, ...]]:
        return Radio, tuple(getattr(self, field.name) for field in fields(Radio))


class _Stored:
    """An array of the buffer, which becomes an attribute when it is first read."""

    # functools.cached_property of Python 3.11 takes a lock, which costs more than the array
    def __init__(self, name: str) -> None:
        self._name = name

    def __get__(self, radio: StoredRadio, owner: type | None = None) -> NDArray[Any]:
        view = vars(radio)[self._name] = radio._layout.view(radio._buffer, self._name, len(radio.edges))
        return view


for _name in LEDGER:
    setattr(StoredRadio, _name, _Stored(_name))
