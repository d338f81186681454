"""The pose of a robot: dead reckoning from its own commands, corrected by fixes with scalar gains.

Between two fixes the pose moves as the commanded twist says. Each new fix corrects position and heading by the share
K = P / (P + sigma^2) of its difference: P is the variance of the own pose, sigma is told. An old fix is compared with
the own pose of its tick. docs/explanation/noise.md has the reasons and the measurements.

A sensor that is told to be exact is believed: its fix of this tick is the pose, to the bit.
"""

from typing import NamedTuple

import numpy as np

from fes.arrays import geometry
from fes.arrays.types import Bools, Floats, Ints
from fes.model import counts, kinematics
from fes.model.config import AgentConfig
from fes.model.sensing import Sensed

SLIP = 0.2
"""Growth of the position's error between fixes, per axis [m/sqrt(s)] (q): slip, and lag that is not told."""

TURN_SLIP = 0.1
"""Growth of the heading's error [rad/sqrt(s)]."""

GATE = 5.0
"""A fix that is farther away than so many standard deviations is ignored."""

REJECTIONS = 5
"""So many ignored fixes in a row mean that the robot is elsewhere: the last of them is believed."""

MEMORY = 1.0
"""Age of the oldest fix that can be compared, and longest time without a step after which a robot starts anew [s]."""

NEVER = -1


class Localizer(NamedTuple):
    """The constants of a crew's localization."""

    is_on: bool
    """False: each pose is taken as it was sensed."""
    dt: float
    lag: float
    """Time constant of the bodies [s]."""
    noise: Floats
    """Variance of a fix: of each coordinate [m^2], and of the heading [rad^2] [2]."""
    growth: Floats
    """Growth of these variances per tick [2]."""
    memory: int
    """Most ticks that are remembered."""

    @property
    def believes_fixes(self) -> bool:
        """True if a fix of this tick is the pose itself."""
        return not self.is_on or not self.noise.any()

    @property
    def is_exact(self) -> bool:
        """True if, beside that, nothing but the last command predicts the next pose: bodies do not lag."""
        return self.believes_fixes and (not self.is_on or self.lag == 0.0)


class Located(NamedTuple):
    """The state: where the robots of a crew are, as far as they know."""

    tick: int
    """Tick of the last step."""
    poses: Floats
    """Own poses at that tick [n, 3]."""
    variance: Floats
    """Variance of each coordinate [m^2] and of the heading [rad^2] [n, 2]."""
    actual: Floats
    """Twists of the bodies as modelled [n, 2]."""
    commands: Floats
    """Last commanded twists [n, 2]."""
    used: Ints
    """Tick of the newest fix that was taken or ignored [n]; NEVER before the first."""
    rejected: Ints
    """Fixes ignored in a row [n]."""
    past: Floats
    """Own poses at the last k ticks, this one included [k, n, 3]."""


def of(config: AgentConfig) -> Localizer:
    """The localization of a crew with this configuration."""
    sheet, dt = config.sensors, config.dt
    noise = np.array([sheet.pose_noise * sheet.pose_noise, sheet.heading_noise * sheet.heading_noise])
    growth = np.array([SLIP * SLIP * dt, TURN_SLIP * TURN_SLIP * dt])
    memory = min(counts.ticks_within(MEMORY, dt), 1000) + 1
    return Localizer(config.localization.filter != "none", dt, sheet.actuator_lag, noise, growth, memory)


def start(n: int) -> Located:
    """The state of `n` robots that had no fix yet."""
    none, still = np.full(n, NEVER), np.zeros((n, 2))
    return Located(NEVER, np.zeros((n, 3)), still, still, still, none, 0 * none, np.zeros((1, n, 3)))


def at_fixes(tick: int, poses: Floats, commands: Floats, is_known: Bools) -> Located:
    """The state after a tick at which the poses [n, 3] were the fixes; robots that are not known start anew."""
    used = np.where(is_known, tick, NEVER)
    nothing = np.zeros_like(commands)
    return Located(tick, poses, nothing, nothing, commands, used, 0 * used, poses[None])


def forget(located: Located, restarted: Bools) -> Located:
    """The state in which the robots `restarted` [n] had no fix yet."""
    blank, lost = start(len(restarted)), restarted[:, None]
    return Located(
        located.tick,
        np.where(lost, blank.poses, located.poses),
        np.where(lost, blank.variance, located.variance),
        np.where(lost, blank.actual, located.actual),
        np.where(lost, blank.commands, located.commands),
        np.where(restarted, blank.used, located.used),
        np.where(restarted, blank.rejected, located.rejected),
        np.where(lost, blank.past, located.past),
    )


def is_fixed(sensed: Sensed) -> bool:
    """True if all poses were measured at this tick."""
    return sensed.fixed is None or bool((sensed.fixed == sensed.tick).all())


@np.errstate(over="ignore", invalid="ignore")  # a message may hold any finite pose
def locate(localizer: Localizer, located: Located, sensed: Sensed) -> Located:
    """The state at this tick, after the fixes in `sensed`; its commands are those before.

    Where all poses are the fixes, its array is that of `sensed`.
    """
    tick, poses = sensed.tick, sensed.poses
    is_new = is_fixed(sensed)
    if not localizer.is_on or (is_new and localizer.is_exact):
        return at_fixes(tick, poses, located.commands, np.ones(len(poses), dtype=np.bool_))
    fixed = np.full(len(poses), tick) if sensed.fixed is None else sensed.fixed
    corrected = _corrected(localizer, _predicted(localizer, located, tick), poses, fixed)
    return corrected._replace(poses=poses) if is_new and localizer.believes_fixes else corrected


def sensed(localizer: Localizer, located: Located) -> Sensed:
    """The poses at which the robots believe to be, as the measurements of their tick."""
    is_noisy = localizer.is_on and bool(localizer.noise.any())
    return Sensed(located.tick, located.poses, None, np.sqrt(located.variance[:, 0]) if is_noisy else None)


def command(located: Located, twists: Floats) -> Located:
    """The state after the robots have commanded `twists` [n, 2] at its tick."""
    return located._replace(commands=twists)


def _predicted(localizer: Localizer, located: Located, tick: int) -> Located:
    """The state at `tick`, by the commands alone; after a long time, or a step back, the robots start anew."""
    ticks = tick - located.tick
    if not 0 < ticks < localizer.memory:
        return start(len(located.used))._replace(tick=tick)
    poses, variance, actual, past = located.poses, located.variance, located.actual, [located.past]
    for _ in range(ticks):  # on a live clock the bodies hold their last command
        mean, actual = kinematics.respond(actual, located.commands, localizer.lag, localizer.dt)
        poses = kinematics.move(poses, mean, localizer.dt)
        variance = variance + localizer.growth
        past.append(poses[None])
    # Fixes up to the last one of every robot need no comparison any more.
    needed = min(localizer.memory, tick - min(located.used.tolist(), default=tick))
    return located._replace(
        tick=tick, poses=poses, variance=variance, actual=actual, past=np.concatenate(past)[-max(1, needed) :]
    )


def _corrected(localizer: Localizer, now: Located, fixes: Floats, fixed: Ints) -> Located:
    """The state after the `fixes` [n, 3], measured at the ticks `fixed` [n]."""
    rows, age = np.arange(len(fixed)), now.tick - fixed
    is_first = now.used == NEVER
    is_new = (fixed > now.used) & (age < localizer.memory) & ~is_first
    # before its first fix, a robot stood where that was
    then = now.past[np.maximum(len(now.past) - 1 - np.where(is_new, age, 0), 0), rows]
    change = fixes - then
    change[:, geometry.HEADING] = geometry.wrap(change[:, geometry.HEADING])
    # the gate: by the position alone, for both
    total = now.variance + localizer.noise
    distance = change[:, geometry.X] * change[:, geometry.X] + change[:, geometry.Y] * change[:, geometry.Y]
    is_exact = (age == 0) & localizer.believes_fixes
    is_far = is_new & ~(distance <= GATE * GATE * total[:, 0]) & ~is_exact
    rejected = np.where(is_new, np.where(is_far, now.rejected + 1, 0), now.rejected)
    is_reset = is_first | (is_far & (rejected == REJECTIONS))
    is_taken = (is_new & ~is_far) | is_reset
    gain = np.where(total > 0.0, now.variance / np.where(total > 0.0, total, 1.0), 1.0)
    gain = np.where(is_reset[:, None], 1.0, np.where(is_taken[:, None], gain, 0.0))
    change = np.where(is_taken[:, None], change * gain[:, [0, 0, 1]], 0.0)
    moved = _moved(now.poses[None], change)[0]
    believed = (is_first | (is_taken & (is_reset | is_exact) & (age == 0)))[:, None]
    poses = np.where(believed, fixes, moved)
    past = np.where(is_first[:, None], fixes, _moved(now.past, change))
    past[-1] = poses
    return now._replace(
        poses=poses,
        variance=np.where(is_taken[:, None], gain * localizer.noise, now.variance),
        actual=np.where(is_reset[:, None], 0.0, now.actual),
        used=np.where(is_first | is_new, fixed, now.used),
        rejected=np.where(is_reset, 0, rejected),
        past=past,
    )


def _moved(poses: Floats, change: Floats) -> Floats:
    """Poses [k, n, 3], each robot's moved by its `change` [n, 3]; robots that do not move keep their digits."""
    result = poses + change
    result[..., geometry.HEADING] = geometry.wrap(result[..., geometry.HEADING])
    is_moved = np.logical_or.reduce(change != 0.0, axis=1)
    return np.where(is_moved[:, None], result, poses)
