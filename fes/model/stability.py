"""Rules between the tick and the gains: they reject settings that cannot be stable, or that need unbounded work.

Both sides check them: the world when it reads a scenario, a crew when it gets its settings.

- (6) is held over a tick (Euler). Of two robots that see only each other, each moves mu e dt / 2, so that
  (1 - mu dt) e of the error e remains. The error grows from mu dt = 2 on. In chains of links with alternating errors
  it may grow from mu dt = 1 on.
- (7) is followed along its exact flow (`agents.laws.formation`), and (18) is integrated with its filters exactly
  (`agents.laws.collocation`): neither bounds mu', beta_h or kappa by itself.
- Estimates of a measured run step by Euler: r_ij += dt [kappa (r_ji of a tick before - r_ij) - 0.3 G/H]. The
  disagreement follows d(k+1) = (1 - (kappa + g) dt) d(k) - kappa dt d(k-1), g <= 0.3 /s. By Jury's criterion it
  decays iff kappa dt < 1 and g dt < 2.
"""

import math

from fes.model import counts
from fes.model.config import FormationConfig, SeekingConfig

MAX_STEPS = 10_000
"""Largest number of integration steps per tick."""

MAX_TICKS = 1e9
"""Largest number of ticks of a run, and of one period of a physical dither."""

MAX_WASHOUT = 100.0
"""Largest washout cut-off times a step of the integration: its quadrature errs by 2e-9 at 100, by 1e-4 at 200."""

NEWTON = 0.3
"""Share of Newton's step that a measured estimate takes in a second (`agents.laws.packet_counting`) [1/s]."""


def check(dt: float, seeking: SeekingConfig, formation: FormationConfig) -> None:
    """Raise ValueError in one line, the rule and then the value, unless ticks of `dt` [s] suit these gains."""
    counts.check("run.dt / seeking.sub_step", dt, seeking.sub_step, MAX_STEPS)
    _below("formation.linear_gain x run.dt", formation.linear_gain * dt, 2.0)
    if seeking.index != "oracle":
        period = 2.0 * math.pi / seeking.dither_frequency
        counts.check("the period of seeking.dither_frequency / run.dt", period, dt, MAX_TICKS)
    if seeking.index == "measured":
        _below("seeking.consensus_gain x run.dt of a measured index", seeking.consensus_gain * dt, 1.0)
        _below(f"{NEWTON:g} /s x run.dt of a measured index", NEWTON * dt, 2.0)
        return
    step = dt / counts.steps(dt, seeking.sub_step)
    if seeking.washout_cutoff * step > MAX_WASHOUT:
        reached = seeking.washout_cutoff * step
        raise ValueError(
            f"seeking.washout_cutoff x a step of the integration must be at most {MAX_WASHOUT:g}, got {reached:g}"
        )


def _below(name: str, value: float, bound: float) -> None:
    if value >= bound:
        raise ValueError(f"{name} must be below {bound:g}, got {value:g}: it cannot be stable")
