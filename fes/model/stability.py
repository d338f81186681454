"""Rules between the tick and the gains: they reject settings that cannot be stable, or that need unbounded work.

Both sides check them: the world when it reads a scenario, a crew when it gets its settings.

- (6) is held over a tick (Euler). Of two robots that see only each other, each moves mu e dt / 2, so that
  (1 - mu dt) e of the error e remains. The error grows from mu dt = 2 on. In chains of links with alternating errors
  it may grow from mu dt = 1 on.
- (7) is followed along its exact flow (`agents.control.motion`), and (18) is integrated with its filters exactly
  (`agents.laws.collocation`): neither bounds mu', beta_h or kappa by itself.
- Each seeking law checks its own settings (`fes.model.seeking`).
"""

from fes.model import counts
from fes.model.config import FormationConfig
from fes.model.seeking import SeekingConfig
from fes.model.table import Use


def check(dt: float, seeking: SeekingConfig, formation: FormationConfig) -> None:
    """Raise ValueError in one line, the rule and then the value, unless ticks of `dt` [s] suit these gains."""
    if not isinstance(seeking, Use):  # an extension checks its own parameters
        seeking.check(dt)
    counts.below("formation.linear_gain x run.dt", formation.linear_gain * dt, 2.0)
