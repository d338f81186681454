"""Integration error against the step: evidence for the default sub-step and tick."""

import numpy as np

from agents.laws import oracle, perturbation
from agents.laws.perturbation import Seeker
from console.analysis import history
from fes.arrays.types import Floats
from fes.model.config import ChannelConfig, ObjectiveConfig
from fes.model.seeking import OracleConfig
from world.config.scenario import Scenario

STARTS = np.array([50.0, 60.0, 80.0, 90.0])
"""Initial estimates of the seeking study [m], those of the paper's scenario."""

SUB_STEPS = (0.02, 0.01, 0.005, 0.0025)
TICKS = (0.05, 0.02, 0.01, 0.005)
REFERENCE_SUB_STEP = 0.00125
REFERENCE_TICK = 0.00125
SPAN = 4.0
"""Time over which estimates are compared [s]."""

HORIZON = 6.0
"""Time over which formations are compared [s]."""


def seeking_error(sub_step: float, transform: str = "none", starts: Floats = STARTS) -> float:
    """Largest error of the estimate over SPAN, as a fraction of its travel."""
    reference = _path(REFERENCE_SUB_STEP, transform, starts)
    travel = np.abs(reference - starts).max(axis=0)
    return float((np.abs(_path(sub_step, transform, starts) - reference).max(axis=0) / travel).max())


def tick_errors(scenario: Scenario, ticks: tuple[float, ...] = TICKS) -> list[tuple[float, float]]:
    """(tick [s], largest distance [m] at HORIZON between robots run with this tick and with REFERENCE_TICK).

    The channel is perfect: losses depend on the tick, and would hide the error.
    """
    reference = _final(scenario, REFERENCE_TICK)
    displacements = [_final(scenario, tick) - reference for tick in ticks]
    return [(tick, float(np.hypot(*error.T).max())) for tick, error in zip(ticks, displacements, strict=True)]


def seeking_errors() -> dict[str, list[tuple[float, float]]]:
    """(sub-step [s], error as a fraction of the travel) for both transforms of the index."""
    return {name: [(step, seeking_error(step, name)) for step in SUB_STEPS] for name in ("none", "log")}


def _path(sub_step: float, transform: str, starts: Floats) -> Floats:
    """Estimates [t, l] [m] of links without consensus, every 20 ms."""
    gain = 44460.0 if transform == "none" else 40000.0
    config = OracleConfig(index_transform=transform, index_gain=gain, sub_step=sub_step)  # type: ignore[arg-type]
    index = oracle.FormulaIndex(ObjectiveConfig(), ChannelConfig(), config.index_transform)
    seeker = Seeker(config, index, 0.02)
    state, path = perturbation.begin(seeker, 0, starts), []
    for tick in range(round(SPAN / seeker.dt)):
        state = perturbation.advance(seeker, tick, state, np.full(len(starts), np.nan))
        path.append(state[perturbation.ESTIMATE])
    return np.array(path)


def _final(scenario: Scenario, tick: float) -> Floats:
    """Positions [n, 2] [m] at HORIZON with this tick."""
    run = scenario.run.model_copy(update={"dt": tick, "duration": HORIZON + tick})
    channel = scenario.channel.model_copy(update={"model": "perfect"})
    seen = history.follow(scenario.model_copy(update={"run": run, "channel": channel}))
    return seen.poses[round(HORIZON / tick), :, :2]
