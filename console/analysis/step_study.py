"""Integration error against the step: evidence for the default sub-step and tick."""

import numpy as np

from agents.laws import oracle, perturbation
from agents.laws.perturbation import Seeker
from console.analysis import history
from console.terminal import counting
from console.terminal.counting import Watch
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


TRANSFORMS = ("none", "log")


def seeking_steps() -> int:
    """Number of sub-steps of `seeking_errors`."""
    return len(TRANSFORMS) * round(sum(SPAN / step for step in (REFERENCE_SUB_STEP, *SUB_STEPS)))


def seeking_errors(watch: Watch = counting.ignore) -> dict[str, list[tuple[float, float]]]:
    """(sub-step [s], error as a fraction of the travel) for both transforms of the index.

    `watch` is called with the completed sub-steps.
    """
    errors: dict[str, list[tuple[float, float]]] = {}
    steps = (REFERENCE_SUB_STEP, *SUB_STEPS)
    watches = iter(counting.parts(watch, *(round(SPAN / step) for step in steps * len(TRANSFORMS))))
    for name in TRANSFORMS:
        reference, *paths = (_path(step, name, STARTS, next(watches)) for step in steps)
        errors[name] = [(step, _error(path, reference)) for step, path in zip(SUB_STEPS, paths, strict=True)]
    return errors


def seeking_error(sub_step: float, transform: str = "none", starts: Floats = STARTS) -> float:
    """Largest error of the estimate over SPAN, as a fraction of its travel."""
    return _error(_path(sub_step, transform, starts), _path(REFERENCE_SUB_STEP, transform, starts))


def tick_steps() -> int:
    """Number of ticks of `tick_errors`."""
    return sum(map(_ticks, (REFERENCE_TICK, *TICKS)))


def tick_errors(
    scenario: Scenario, ticks: tuple[float, ...] = TICKS, watch: Watch = counting.ignore
) -> list[tuple[float, float]]:
    """(tick [s], largest distance [m] at HORIZON between robots run with this tick and with REFERENCE_TICK).

    The channel is perfect: losses depend on the tick, and would hide the error. `watch` is called with the completed
    ticks.
    """
    first, *others = counting.parts(watch, *map(_ticks, (REFERENCE_TICK, *ticks)))
    reference = _final(scenario, REFERENCE_TICK, first)
    displacements = [_final(scenario, tick, own) - reference for tick, own in zip(ticks, others, strict=True)]
    return [(tick, float(np.hypot(*error.T).max())) for tick, error in zip(ticks, displacements, strict=True)]


def _error(path: Floats, reference: Floats) -> float:
    """Largest difference of two paths [t, l] [m], as a fraction of the travel of the second."""
    travel = np.abs(reference - reference[0]).max(axis=0)
    return float((np.abs(path - reference).max(axis=0) / travel).max())


def _path(sub_step: float, transform: str, starts: Floats, watch: Watch = counting.ignore) -> Floats:
    """Estimates [t, l] [m] of links without consensus, every 20 ms, from `starts` [l] [m] on."""
    gain = 44460.0 if transform == "none" else 40000.0
    config = OracleConfig(index_transform=transform, index_gain=gain, sub_step=sub_step)  # type: ignore[arg-type]
    index = oracle.FormulaIndex(ObjectiveConfig(), ChannelConfig(), config.index_transform)
    seeker = Seeker(config, index, 0.02)
    state, path = perturbation.begin(seeker, 0, starts), [starts]
    for tick in range(round(SPAN / seeker.dt)):
        state = perturbation.advance(seeker, tick, state, np.full(len(starts), np.nan))
        path.append(state[perturbation.ESTIMATE])
        watch((tick + 1) * seeker.sub_steps)
    return np.array(path)


def _ticks(tick: float) -> int:
    """Ticks up to HORIZON, the last one included."""
    return round(HORIZON / tick) + 1


def _final(scenario: Scenario, tick: float, watch: Watch) -> Floats:
    """Positions [n, 2] [m] at HORIZON with this tick."""
    run = scenario.run.model_copy(update={"dt": tick, "duration": HORIZON + tick})
    channel = scenario.channel.model_copy(update={"model": "perfect"})
    seen = history.follow(scenario.model_copy(update={"run": run, "channel": channel}), watch=watch)
    return seen.poses[round(HORIZON / tick), :, :2]
