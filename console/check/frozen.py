"""An extension whose inputs cannot be written to: numpy raises an error where it tries."""

import dataclasses
from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from agents.control.state import Crew
from fes.arrays.types import Bools
from fes.model.contacts import Contacts
from world.config.radio import RadioConfig
from world.metrics.collector import MetricsCollector
from world.simulation.reception import Reception
from world.simulation.truth import World

READ_ONLY = "read-only"
"""Word in numpy's errors for an array that must not be written to."""


class Frozen:
    """An extension, each of whose calls gets arrays that are read-only while it lasts."""

    def __init__(self, inner: Any) -> None:
        self._inner = inner

    def __call__(self, contacts: Contacts) -> Bools:
        """The result of a neighbor rule."""
        selected: Bools = _call(self._inner, (contacts,))
        return selected

    def __getattr__(self, name: str) -> Any:
        value = getattr(self._inner, name)
        return (lambda *arguments: _call(value, arguments)) if callable(value) else value


class FrozenReception(Reception):
    """The reception models of a world, as Frozen."""

    def of(self, config: RadioConfig) -> Any:
        """The reception model of a channel."""
        return Frozen(super().of(config))


def robots(crew: Crew) -> Crew:
    """The crew with laws whose inputs are frozen; a controller gets no array, and its object is its state."""
    if crew.config.controller is not None:
        return replace(crew, rule=Frozen(crew.rule))
    return replace(crew, rule=Frozen(crew.rule), formation=Frozen(crew.formation), seeking=Frozen(crew.seeking))


def parts(world: World, metrics: MetricsCollector) -> tuple[World, MetricsCollector]:
    """The world and its metrics, with extensions whose inputs are frozen."""
    metrics.extensions = {name: Frozen(metric) for name, metric in metrics.extensions.items()}
    medium = replace(world.medium, reception=FrozenReception(world.medium.reception.context))
    return replace(world, medium=medium, dynamics=Frozen(world.dynamics)), metrics


def _call(function: Any, arguments: tuple[Any, ...]) -> Any:
    arrays = [array for array in _arrays(arguments, set()) if array.flags.writeable]
    for array in arrays:
        array.flags.writeable = False
    try:
        return function(*arguments)
    finally:
        for array in sorted(arrays, key=lambda array: array.base is not None):  # a view only after its base
            array.flags.writeable = True


def _arrays(value: Any, seen: set[int]) -> Iterator[NDArray[Any]]:
    """Every array within a value, those that a table computes on demand included."""
    if id(value) in seen or isinstance(value, type):
        return
    seen.add(id(value))
    if isinstance(value, np.ndarray):
        yield value
    elif isinstance(value, dict):
        for inner in value.values():
            yield from _arrays(inner, seen)
    elif isinstance(value, tuple | list):
        for inner in value:
            yield from _arrays(inner, seen)
    elif dataclasses.is_dataclass(value):
        for name in [*(field.name for field in dataclasses.fields(value)), *_derived(value)]:
            yield from _arrays(getattr(value, name, None), seen)


def _derived(value: Any) -> list[str]:
    """Names of the arrays that a table of this project computes on demand."""
    if type(value).__module__.partition(".")[0] not in ("fes", "world"):
        return []
    return [
        name
        for base in type(value).__mro__
        for name, member in vars(base).items()
        if isinstance(member, cached_property)
    ]
