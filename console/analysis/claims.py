"""Errors in the paper's text, and the team index: each claim as a computation that returns its numbers.

`fes claims` lists and runs all, `fes claims NAME` runs one. `docs/explanation/paper.md` explains the numbers of the
paper, and `team.md` beside it those of the team index.
"""

import math
from collections.abc import Callable

import numpy as np

from agents.laws import formation, oracle, perturbation
from agents.laws.perturbation import Seeker
from console.analysis import team_claims
from console.backends import inprocess, stacked
from fes.arrays.edges import Edges
from fes.arrays.types import Floats
from fes.model.config import ChannelConfig, FormationConfig, ObjectiveConfig
from fes.model.seeking import OracleConfig
from world.config import builtin
from world.config.scenario import Scenario, load
from world.metrics import optimum

Numbers = dict[str, float]

SEEDS = 5
"""Number of runs of a formation with a different end for each seed."""

PAIR = np.array([58.0, 78.0])
"""Two estimates of one link, 20 m apart [m]."""


def printed_law() -> Numbers:
    """(18) as printed: beta_l r_hat + xi is conserved, and the disagreement freezes at 2/(2 + beta_l)."""
    config = OracleConfig(law="paper", index_transform="none", index_gain=1.0)
    start, end = _pair(config, 10.0)
    conserved = config.low_pass_cutoff * end[perturbation.ESTIMATE] + end[perturbation.DRIFT]
    _, with_gain = _pair(config.model_copy(update={"index_gain": 44460.0}), 10.0)
    return {
        "disagreement at the start [m]": 20.0,
        "disagreement after 10 s [m]": float(np.ptp(end[perturbation.ESTIMATE])),
        "2/(2 + beta_l) of the start [m]": 20.0 * 2.0 / (2.0 + config.low_pass_cutoff),
        "disagreement after 10 s with an index gain of 44460 [m]": float(np.ptp(with_gain[perturbation.ESTIMATE])),
        "change of beta_l r_hat + xi": float(
            np.abs(conserved - config.low_pass_cutoff * start[perturbation.ESTIMATE]).max()
        ),
    }


def corrected_law() -> Numbers:
    """(18) with one sign reversed: the disagreement vanishes, with eigenvalues -6 +- 5.29i."""
    config = OracleConfig(index_transform="none", index_gain=1.0)
    _, end = _pair(config, 4.0)
    low, kappa = config.low_pass_cutoff, config.consensus_gain
    # d' = e - 2 kappa d, e' = -beta_l e - 2 kappa beta_l d, for d = r_ij - r_ji and e = xi_ij - xi_ji
    values = np.linalg.eigvals(np.array([[-2.0 * kappa, 1.0], [-2.0 * kappa * low, -low]]))
    printed = np.linalg.eigvals(np.array([[-2.0 * kappa, 1.0], [2.0 * kappa * low, -low]]))
    return {
        "disagreement after 4 s [m]": float(np.ptp(end[perturbation.ESTIMATE])),
        "eigenvalues, real part [1/s]": float(values.real.max()),
        "eigenvalues, imaginary part [rad/s]": float(values.imag.max()),
        "printed law, largest eigenvalue [1/s]": float(printed.real.max()),
        "printed law, smallest eigenvalue [1/s]": float(printed.real.min()),
    }


def time_constant() -> Numbers:
    """The printed gains: a gradient time constant of half a day; and the modes for a gain of 44460."""
    washout = 100.0**2 / (100.0**2 + 25.0**2)  # in-phase part of the dither that passes the washout
    slow, fast = sorted(-np.roots([1.0, 4.0, 4.0 * washout]).real)  # s^2 + beta_l s + beta_l (rate of the gradient)
    numbers = {"slow mode at gain 44460, with washout and low-pass [s]": 1.0 / slow, "its fast mode [s]": 1.0 / fast}
    for nearest in (50.0, 100.0):
        second = _curvature(ObjectiveConfig(minimum_separation=nearest))
        numbers[f"1/(a^2 |J''|/2) for r_min {nearest:.0f} [s]"] = 1.0 / (0.2**2 * abs(second) / 2.0)
    return numbers


def two_exponents() -> Numbers:
    """r* for each reading of nu: only 4 in the index and 3 in the path loss give Fig. 3."""
    numbers = {}
    for shape in (2.0, 3.0, 4.0):
        for nearest in (50.0, 100.0):
            objective = ObjectiveConfig(minimum_separation=nearest, shape_exponent=shape)
            best = optimum.optimal_separation(objective, ChannelConfig())
            numbers[f"r* with shape exponent {shape:.0f}, r_min {nearest:.0f} [m]"] = best
    return numbers


def weights() -> Numbers:
    """(9) against (1): the weights leave 0 for a_ii, and a_ij is not a_ji as (12) assumes."""
    three = Edges(np.array([0]), np.array([0, 0, 0]), np.array([1, 2, 3]))
    two = Edges(np.array([0]), np.array([0, 0]), np.array([1, 2]))
    single = Edges(np.array([0]), np.array([0]), np.array([1]))
    from_three = formation.weights(three, np.array([1.0, 5.0, 2.0]))
    from_two = formation.weights(two, np.array([1.0, 9.0]))
    return {
        "sum of weights, three neighbors": float(from_three.sum()),
        "a_ii by (1), three neighbors": 1.0 - float(from_three.sum()),
        "sum of weights, one neighbor": float(formation.weights(single, np.array([3.0])).sum()),
        "a_ij of a robot with three neighbors": float(from_three[0]),
        "a_ji of its peer with two": float(from_two[0]),
    }


def theorem_1() -> Numbers:
    """(12) drops cross terms: a robot at rest between two equal errors, whose V falls according to (12)."""
    best = optimum.optimal_separation(ObjectiveConfig(), ChannelConfig())
    # Both peers are straight ahead, the first 1 m too far, the second 1 m too near. They face sideways: their v is 0.
    ahead = np.array([best + 1.0, best - 1.0])
    pair = Edges(np.array([0]), np.array([0, 0]), np.array([1, 2]))
    error = ahead - best
    share = formation.weights(pair, error)
    speed = float((share * error).sum())  # (6) with mu = 1, all bearings zero
    return {
        "speed of the robot by (6) [m/s]": speed,
        "dV/dt by the chain rule [m^2/s]": 0.0 - 2.0 * speed * float(error.sum()),
        "dV/dt by (12) [m^2/s]": -2.0 * float((share * error**2).sum()),
    }


def disk_graph() -> Numbers:
    """Every robot in range a neighbor: Problem 1 has no solution, and the robots end in a frustrated cluster.

    The end of a frustrated formation is chaotic, and depends on the last bit of exp: hence several seeds.
    """
    start = _scenario("disk")
    seeds = [start.model_copy(update={"run": start.run.model_copy(update={"seed": seed})}) for seed in range(SEEDS)]
    lengths = np.array([[edge[2] for edge in summary["edges"]] for summary in stacked.run(seeds, "paper")])
    shortest, longest = lengths.min(axis=1), lengths.max(axis=1)
    return {
        "seeds": float(SEEDS),
        "links": float(lengths.shape[1]),
        "shortest link, least over seeds [m]": float(shortest.min()),
        "shortest link, most over seeds [m]": float(shortest.max()),
        "longest link, least over seeds [m]": float(longest.min()),
        "longest link, most over seeds [m]": float(longest.max()),
        "r* [m]": optimum.optimal_separation(start.objective, start.channel),
    }


def two_parts() -> Numbers:
    """Two nearest neighbors: the links start in two components; the relative neighborhood graph is connected."""
    numbers = {}
    for rule in ("two_nearest", "relative_neighborhood"):
        summary = inprocess.run(_scenario(rule), "paper")
        numbers[f"{rule}: links always connected"] = float(summary["links_connected_always"])
        numbers[f"{rule}: largest error of a link at the end [m]"] = summary["separation_error_max"]
    return numbers


CLAIMS: dict[str, Callable[[], Numbers]] = {
    "printed-law": printed_law,
    "corrected-law": corrected_law,
    "time-constant": time_constant,
    "two-exponents": two_exponents,
    "weights": weights,
    "theorem-1": theorem_1,
    "disk-graph": disk_graph,
    "two-parts": two_parts,
    "team-index": team_claims.team_index,
}


def _pair(config: OracleConfig, duration: float) -> tuple[Floats, Floats]:
    """State [3, 2] of the two ends of one link at the start and after `duration` [s]."""
    index = oracle.FormulaIndex(ObjectiveConfig(), ChannelConfig(), config.index_transform)
    seeker = Seeker(config, index, 0.02)
    start = state = perturbation.begin(seeker, 0, PAIR)
    for tick in range(math.ceil(duration / seeker.dt)):
        received = perturbation.extrapolate(seeker, state, state[perturbation.ESTIMATE, ::-1], np.zeros(2))
        state = perturbation.advance(seeker, tick, state, received)
    return start, state


def _curvature(objective: ObjectiveConfig) -> float:
    """J'' at r* [1/m^2], by central differences."""
    h = 0.02
    separations = optimum.optimal_separation(objective, ChannelConfig()) + h * np.array([-1.0, 0.0, 1.0])
    below, center, above = oracle.FormulaIndex(objective, ChannelConfig(), "none")(separations)
    return float((below - 2.0 * center + above) / h**2)


def _scenario(rule: str) -> Scenario:
    paper = load(builtin.file_of("paper"))
    graph = FormationConfig.model_validate({**paper.formation.model_dump(), "rule": rule})
    return paper.model_copy(update={"formation": graph})
