"""The compiled numbers of links repeat those of numpy to the bit."""

import numpy as np
import pytest

from fes.arrays.edges import Edges
from fes.model.sensing import Telemetry
from tests.support import bits, cores, layouts
from world.metrics import link_errors
from world.simulation.core import compiled_world

pytestmark = cores.needs(compiled_world.load())

ODD = [np.nan, np.inf, -np.inf, 0.0, -0.0, 5e-324, 1e300]


def random_links(rng: np.random.Generator, robots: int, share: float) -> Edges:
    """Links of which some have only one direction."""
    pairs = np.argwhere(rng.random((robots, robots)) < share)
    return layouts.edges(range(robots), [(int(a), int(b)) for a, b in pairs if a != b])


def numbers(links: Edges, poses: np.ndarray, estimates: np.ndarray, optimal: float) -> list[np.ndarray]:
    telemetry = Telemetry(links, estimates, np.zeros((2, 0)), np.zeros((len(poses), 0)))
    with np.errstate(all="ignore"):
        separation = link_errors.link_separations(links, poses)
        errors = link_errors.link_errors(telemetry, separation, optimal)
    return [separation, np.array([errors[name] for name in link_errors.NUMBERS])]


@pytest.mark.parametrize("robots", [2, 3, 10, 40])
@pytest.mark.parametrize("odd", [0.0, 0.05, 1.0])
def test_the_numbers_of_random_links_are_those_of_numpy(robots: int, odd: float) -> None:
    rng = np.random.default_rng(robots)
    for share in (0.0, 0.1, 0.5, 1.0):
        for _ in range(20):
            links = random_links(rng, robots, share)
            poses, estimates = rng.uniform(-90.0, 90.0, (robots, 3)), rng.uniform(50.0, 90.0, len(links))
            for values in (poses, estimates):
                is_odd = rng.random(values.shape) < odd
                values[is_odd] = rng.choice(ODD, int(is_odd.sum()))
            optimal = float(rng.choice([66.6, *ODD]))
            compiled = numbers(links, poses, estimates, optimal)
            with cores.only_numpy():
                expected = numbers(links, poses, estimates, optimal)
            assert not bits.differences(compiled, expected)


def test_arrays_that_do_not_fit_the_links_are_refused() -> None:
    kernels, links = compiled_world.link_kernels(), layouts.edges(range(3), [(0, 2), (2, 0)])
    assert kernels is not None
    with pytest.raises(ValueError, match="links of 3 robots, poses of 2"):
        kernels.separations(links, np.zeros((2, 3)))
    with pytest.raises(ValueError, match="2 links, 1 estimates and 1 separations"):
        kernels.errors(links, np.zeros(1), np.zeros(1), 1.0)


def test_rows_of_another_memory_order_are_read_as_they_are() -> None:
    links, poses = layouts.edges(range(3), [(0, 2), (2, 0)]), np.arange(9.0).reshape(3, 3)
    kernels = compiled_world.link_kernels()
    assert kernels is not None
    assert kernels.separations(links, np.asfortranarray(poses)).tolist() == kernels.separations(links, poses).tolist()
