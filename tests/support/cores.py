"""The compiled core in tests: some need it, and some exclude it."""

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from agents.core import compiled_crew
from agents.laws.core import formula_index
from fes.arithmetic.core import functions, library
from world.simulation.core import compiled_world

LOADERS = {
    functions.NAME: functions.load,
    compiled_crew.NAME: compiled_crew.load,
    formula_index.NAME: formula_index.load,
    compiled_world.NAME: compiled_world.load,
}
"""The function that loads each library."""


def needs(loaded: object | None) -> pytest.MarkDecorator:
    """Skips the tests of a module where a library could not be loaded, with the reason."""
    reasons = "; ".join(f"{name}: {reason}" for name, reason in library.state.items() if reason != library.C)
    return pytest.mark.skipif(loaded is None, reason=f"no compiled core ({reasons})")


@contextmanager
def only_numpy() -> Iterator[None]:
    """Crews and worlds that are created within this block use numpy, and so do the errors of links."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(compiled_crew, "of", lambda crew: None)
        patch.setattr(compiled_world, "of", lambda ids, medium: None)
        patch.setattr(compiled_world, "link_kernels", lambda: None)
        yield
