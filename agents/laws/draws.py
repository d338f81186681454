"""Random numbers for robots and links. The caller passes them in: a law sees neither a seed nor a generator."""

from dataclasses import dataclass
from typing import Protocol

from fes.arrays import draws
from fes.arrays.types import Floats, Ints


class Draws(Protocol):
    """The random numbers of a crew, as a function of a stream and of ids."""

    def __call__(self, stream: str, robots: Ints, peers: Ints) -> Floats:
        """A uniform number in [0, 1) for each pair of ids (robot, peer) [m]; a robot alone is its own peer."""


@dataclass(frozen=True)
class SeededDraws:
    """The numbers of one run: a function of (seed, stream, robot, peer)."""

    seed: int

    def __call__(self, stream: str, robots: Ints, peers: Ints) -> Floats:
        """A uniform number in [0, 1) for each pair of ids (robot, peer) [m]."""
        return draws.uniform_pairs(draws.key(self.seed, stream), robots, peers)
