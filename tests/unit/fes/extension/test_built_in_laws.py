"""Built-in laws with parameters, and those that are told the channel."""

import pytest

from fes.errors import FesError
from fes.extension import registry
from fes.extension.kinds import FORMATION, SEEKING
from fes.model.table import Use


def test_the_parameters_of_a_built_in_one_are_checked_by_its_class() -> None:
    registry.check(FORMATION, Use.model_validate({"use": "voronoi", "sensing_radius": 34.0}))
    with pytest.raises(FesError, match=r"^formation law 'voronoi': unknown parameter 'radius'; did you mean"):
        registry.check(FORMATION, Use.model_validate({"use": "voronoi", "radius": 34.0}))
    with pytest.raises(FesError, match=r"^formation law 'paper': unknown parameter 'size'; it has none$"):
        registry.check(FORMATION, Use.model_validate({"use": "paper", "size": 3}))


def test_a_built_in_law_is_told_the_channel_by_the_table_of_its_kind() -> None:
    assert registry.is_told(FORMATION, "gradient")
    assert not registry.is_told(FORMATION, Use.model_validate({"use": "voronoi", "gain": 2.0}))
    assert registry.is_told(SEEKING, "oracle")
