"""The seeking law (18) as scalar code."""

import math

from agents.laws import oracle
from agents.laws.perturbation import Seeker
from fes.model.config import ChannelConfig, ObjectiveConfig
from fes.model.seeking import OracleConfig
from tests.support import reference as witness

AMPLITUDE, FREQUENCY, KAPPA, LOW_PASS, WASHOUT = 0.2, 100.0, 4.0, 4.0, 25.0

DT = 0.02


def seeker(law: str = "consensus", gain: float = 44460.0, sub_step: float = 0.01, dt: float = DT) -> Seeker:
    config = OracleConfig.model_validate({"law": law, "index_gain": gain, "sub_step": sub_step})
    return Seeker(config, oracle.FormulaIndex(ObjectiveConfig(), ChannelConfig(), "none"), dt)


def equation_18(law: str, gain: float, heard: float) -> witness.Rate:
    """(18) for one link, transcribed; `law` chooses the sign of the second kappa term."""

    def rate(t: float, state: list[float]) -> tuple[float, float, float]:
        estimate, drift, baseline = state
        probe = AMPLITUDE * math.sin(FREQUENCY * t)
        index = gain * witness.paper_index(estimate + probe)
        consensus = 0.0 if math.isnan(heard) else KAPPA * (heard - estimate)
        sign = -1.0 if law == "paper" else 1.0
        return (
            drift + consensus,
            LOW_PASS * (-drift + (index - baseline) * probe + sign * consensus),
            WASHOUT * (-baseline + index),
        )

    return rate
