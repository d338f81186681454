"""Motion: the twists that follow a formation law's pull; equations (6), (7)."""

import numpy as np

from fes.arithmetic import elementary
from fes.arrays import geometry
from fes.arrays.types import Floats, Ints
from fes.errors import FesError
from fes.extension.protocols import Formed
from fes.model.config import FormationConfig
from fes.model.sensing import MAX_TWIST, Sensed, bounded


def twists(ids: Ints, formed: Formed, sensed: Sensed, dt: float, config: FormationConfig) -> Floats:
    """Twists [n, 2] [m/s, rad/s] of robots `ids` [n]; raises FesError for one that is not finite."""
    result = twist(formed.pull, sensed.poses[:, geometry.HEADING], dt, config)
    if formed.twists is not None:
        result = np.where(np.isnan(formed.twists), result, limited(formed.twists, config))
    if np.logical_and.reduce(np.abs(result) <= MAX_TWIST, axis=None):
        return result
    if not np.isfinite(result).all():
        robot = int(ids[~np.isfinite(result).all(axis=1)][0])
        raise FesError(
            f"robot {robot} computed a twist that is not finite at tick {sensed.tick}: check gains and exponents"
        )
    return bounded(result, MAX_TWIST)


def twist(vector: Floats, heading: Floats, dt: float, config: FormationConfig) -> Floats:
    """Twists [n, 2] [m/s, rad/s] to hold over a tick of `dt` [s]; equations (6), (7).

    `vector` [n, 2] [m] is g, held over the tick. (7) then turns the heading by delta' = -mu'|g| sin(delta), with
    delta the bearing of g from the heading. At mu' = 10 that is stiff (hundreds of rad/s). So omega is the mean rate
    of the exact flow, tan(delta(h) / 2) = tan(delta_0 / 2) E with E = exp(-mu'|g| h). With c and s, the components
    of g along and across the heading, tan(delta_0 / 2) = s / (|g| + c), and the flow turns by
    2 atan2(s (1 - E), |g| + c + (|g| - c) E). v is that of (6) at the tick's beginning.
    """
    x, y = vector[:, 0], vector[:, 1]
    size = geometry.separation(x, y)
    sine, cosine = elementary.sin_cos(heading)
    along, across = x * cosine + y * sine, y * cosine - x * sine
    rate = config.angular_gain * dt * size
    decay, rise = elementary.exp_and_rise(-rate, rate)
    # Rounding may make the sum negative where g points straight backward.
    ahead = np.maximum((size + along) + (size - along) * decay, 0.0)
    result = np.empty((len(heading), 2))
    result[:, geometry.LINEAR] = config.linear_gain * along
    result[:, geometry.ANGULAR] = 2.0 * elementary.atan2(across * rise, ahead) / dt
    return limited(result, config)


def limited(values: Floats, config: FormationConfig) -> Floats:
    """Twists [n, 2], within the limits of the configuration."""
    if config.linear_limit is None and config.angular_limit is None:
        return values
    result = values.copy()
    for column, limit in ((geometry.LINEAR, config.linear_limit), (geometry.ANGULAR, config.angular_limit)):
        if limit is not None:
            np.clip(result[:, column], -limit, limit, out=result[:, column])
    return result
