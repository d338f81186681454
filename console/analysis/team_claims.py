"""Numbers of the team index that `docs/explanation/team.md` claims."""

from fes.arrays.types import Floats
from fes.extension.context import SeededDraws, WorldContext
from fes.model.config import ObjectiveConfig
from fes.shapes import choice
from world.config.radio import RadioConfig
from world.metrics.best_separation import best_separation
from world.metrics.team import target
from world.metrics.team.team_index import TeamIndex

TEN = 10


def context(objective: ObjectiveConfig) -> WorldContext:
    """The circumstances of a target."""
    return WorldContext(0.02, TEN, objective, SeededDraws(0))


def index_of(places: Floats, objective: ObjectiveConfig | None = None) -> TeamIndex:
    """The team index of two or more robots at `places` [n, 2] [m] over the paper's channel."""
    result = target.of_positions(places, RadioConfig(), context(objective or ObjectiveConfig()))
    if result is None:
        raise ValueError(f"the team index is computed for 2 to 100 robots, got {len(places)}")
    return result


def spacings(name: str, n: int, objective: ObjectiveConfig | None = None) -> tuple[float, float]:
    """r* and r_beta [m] of the shape `name` of `n` robots over the paper's channel."""
    config = objective or ObjectiveConfig()
    shape, circumstances = choice.shape(name, n, config.losses), context(config)
    return best_separation(circumstances, RadioConfig()), target.spacing(shape, RadioConfig(), circumstances)


def team_index() -> dict[str, float]:
    """The team index: J of two robots, and the link length at which a larger team is best."""
    pair, _ = spacings("lattice", 2)
    shape, (best, longer) = choice.shape("lattice", TEN, 1), spacings("lattice", TEN)
    numbers = {
        "r* [m]": best,
        "J at r*, and F of two robots": index_of(pair * choice.shape("lattice", 2, 1).slots).value,
        "beta of ten robots": shape.quality_weight(1, 1.0),
        "r_beta of ten robots [m]": longer,
        "F of ten robots at r*": index_of(best * shape.slots).value,
        "F of ten robots at r_beta": index_of(longer * shape.slots).value,
    }
    for n in (3, TEN, 100):
        numbers[f"r_beta / r*, n = {n}"] = spacings("lattice", n)[1] / best
    coarse = ObjectiveConfig(minimum_separation=100.0)
    farther, farthest = spacings("lattice", TEN, coarse)
    numbers["r_beta / r*, n = 10, r_min 100"] = farthest / farther
    numbers["F at r*, n = 10, r_min 100"] = index_of(farther * shape.slots, coarse).value
    numbers["F at r_beta, n = 10, r_min 100"] = index_of(farthest * shape.slots, coarse).value
    return numbers
