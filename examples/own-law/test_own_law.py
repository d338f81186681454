"""The law keeps the rules of extensions, and pulls as its formula says."""

import numpy as np
from own_law import Saturated, SpringParameters

from fes.extension import Edges, LinkGeometry
from fes.extension.conformance import check


class Around:
    """A robot with two links: one peer to the east, one to the north."""

    links = Edges(ids=np.array([0]), rows=np.array([0, 0]), peers=np.array([1, 2]))


def test_the_law_keeps_the_rules() -> None:
    check("own_law:Saturated", longest=8.0)


def test_a_far_peer_pulls_by_the_longest_pull_and_a_near_one_by_its_error() -> None:
    law = Saturated(SpringParameters(gain=1.0, longest=8.0), context=None)
    links = LinkGeometry(
        separation=np.array([1e6, 70.001]), desired=np.array([70.0, 70.0]), bearing=np.array([[1.0, 0.0], [0.0, 1.0]])
    )
    [(east, north)] = law.step(None, Around(), links).pull
    np.testing.assert_allclose(east, 8.0, rtol=1e-8)  # sqrt(1 + s^2) = s (1 + 1 / (2 s^2)), with s = 1.25e5
    np.testing.assert_allclose(north, 0.001, rtol=1e-7)  # 1 - (0.001 / 8)^2 / 2
