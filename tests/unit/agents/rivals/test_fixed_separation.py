"""The seeking law that does not seek."""

import pytest

from agents.rivals.fixed_separation import FixedSeparation, FixedSeparationParameters
from tests.support.surroundings import context, everyone


def test_every_link_has_the_separation_of_the_parameter() -> None:
    law = FixedSeparation(FixedSeparationParameters(separation=62.5), context(3))
    assert law.desired(None, 7, everyone(3)).tolist() == [62.5] * 6
    published = law.publish(None, everyone(3))
    assert published.estimates.tolist() == [62.5] * 6
    assert (published.statistics.shape, published.learnt.shape) == ((3, 0), (0, 6))


def test_the_default_depends_on_the_objective_alone() -> None:
    # 1 - exp(-(r / 50)^4) = 0.95 at r = 50 (ln 20)^(1/4)
    law = FixedSeparation(FixedSeparationParameters(), context(2))
    assert law.separation == pytest.approx(50.0 * 2.995732273553991**0.25, rel=1e-12)
