"""Rules between the tick and the gains: they reject settings that cannot be stable, or that need unbounded work.

Both sides check them: the world when it reads a scenario, a crew when it gets its settings.

- (6) is held over a tick (Euler). Of two robots that see only each other, each moves mu e dt / 2, so that
  (1 - mu dt) e of the error e remains. The error grows from mu dt = 2 on. In chains of links with alternating errors
  it may grow from mu dt = 1 on.
- (7) is followed along its exact flow (`agents.control.motion`), and (18) is integrated with its filters exactly
  (`agents.laws.collocation`): neither bounds mu', beta_h or kappa by itself.
- The safe separation (`agents.control.separation`) is kept if d - d_safe falls at most by the factor 1 - gamma dt per
  tick. The gain gamma is at most v_max / d_safe: with a larger one, robots that meet block each other.
- Each seeking law checks its own settings (`fes.model.seeking`).
"""

from fes.model import counts
from fes.model.config import FormationConfig, ObjectiveConfig
from fes.model.seeking import SeekingConfig
from fes.model.table import Use


def check(dt: float, seeking: SeekingConfig, formation: FormationConfig, objective: ObjectiveConfig) -> None:
    """Raise ValueError in one line, the rule and then the value, unless ticks of `dt` [s] suit these gains."""
    if not isinstance(seeking, Use):  # an extension checks its own parameters
        seeking.check(dt)
    counts.below("formation.linear_gain x run.dt", formation.linear_gain * dt, 2.0)
    if formation.safe_separation is not None:
        _check_separation(dt, formation.safe_separation, formation, objective)


def _check_separation(dt: float, safe: float, formation: FormationConfig, objective: ObjectiveConfig) -> None:
    """Raise ValueError in one line unless robots can keep apart by `safe` [m] with these gains."""
    limit, gain = formation.linear_limit, formation.separation_gain
    half = objective.minimum_separation / 2.0
    if limit is None:
        raise ValueError(f"formation.safe_separation needs formation.linear_limit, got {safe:g} without it")
    if safe >= half:
        raise ValueError(
            f"formation.safe_separation must be below half of objective.minimum_separation, {half:g} m, got {safe:g}"
        )
    counts.below("formation.separation_gain x run.dt", gain * dt, 1.0)
    if gain > limit / safe:
        raise ValueError(
            "formation.separation_gain must be at most formation.linear_limit / formation.safe_separation, "
            f"{limit / safe:g} /s, got {gain:g}"
        )
