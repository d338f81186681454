"""The paper's shortcut (33): the index computed from the channel's formula, which its robots know.

No process of a measured run imports this module.
"""

from functools import partial
from typing import Any, Literal

import numpy as np

from agents.laws import link_estimates
from agents.laws.core import formula_index
from agents.laws.core.formula_index import Formula
from agents.laws.perturbation import BASELINE, ESTIMATE, WEIGHT
from agents.laws.seeking_perturbation import PerturbationSeeking
from fes.arithmetic import elementary
from fes.arrays.types import Floats
from fes.extension.context import LawContext
from fes.extension.neighborhood import Neighborhood
from fes.model import outage
from fes.model.config import ChannelConfig, ObjectiveConfig
from fes.model.objective import share_of_reach
from fes.model.seeking import OracleConfig

LEAST_SPREAD, MOST_SPREAD = 1e-300, 1e100
"""Bounds of A: between them A/(1 - e^-A) has all its digits, and the squares of slopes are finite."""

NEARLY_ZERO = 1e-9
"""The smallest separation [m] at which the index is evaluated: an estimate may overshoot below zero."""

LEAST = -1e9
"""The smallest logarithm of an index; the index itself rounds to zero below exp(-745). Without this bound the slope
would be infinite at an estimate that is far off, because of a peer's estimate of 1e12 m, say."""


TRUSTED = 0.4
"""Share of a separation, times the largest exponent of the index, over which its parabola counts."""

TRUSTED_WIDTH = 0.1
"""The same as a share of the width of a logistic channel."""


class FormulaIndex:
    """J of (33), or ln J.

    J(r) = S(r) p(r) = [1 - exp(-A)] exp(-w A - b r^nu), with A = (r/r_min)^s and w = (r_min/r_x)^s. For a logistic
    channel, ln p = -ln(1 + e^z) replaces -b r^nu. It is evaluated at many points per tick, and this form has one
    exponential less than `fes.model.objective` and `fes.model.outage`.

    With a `quality_weight` beta of each link [l], the index is [1 - exp(-A)] (exp(-w A) p)^beta; separations then
    have the shape [..., l]. Where beta is above 1, this or its logarithm is divided by beta: the optimum is the same,
    and a large weight would make (18) unstable.
    """

    def __init__(
        self,
        objective: ObjectiveConfig,
        channel: ChannelConfig,
        transform: Literal["log", "none"],
        quality_weight: Floats | None = None,
    ) -> None:
        self._objective, self._channel, self._is_log = objective, channel, transform == "log"
        self._weight = quality_weight
        is_large = quality_weight is not None and bool((quality_weight > 1.0).any())
        self._divisor = np.maximum(1.0, quality_weight) if quality_weight is not None and is_large else None
        self._reach = share_of_reach(objective)
        powers = (objective.shape_exponent, 0.0 if channel.model == "logistic" else channel.path_loss_exponent)
        self._trusted_share = TRUSTED / max(4.0, *powers)
        self._trusted_length = TRUSTED_WIDTH * channel.logistic_width if channel.model == "logistic" else np.inf
        self._loss = 0.0 if channel.model == "logistic" else outage.exponent_scale(channel)

    @property
    def settings(self) -> Formula:
        """The settings of the compiled index, which knows no quality weight."""
        channel, objective = self._channel, self._objective
        return Formula(
            objective.minimum_separation,
            objective.shape_exponent,
            self._reach,
            self._loss,
            channel.path_loss_exponent,
            channel.logistic_midpoint,
            channel.logistic_width,
            channel.model == "logistic",
            self._is_log,
            self._trusted_share,
            self._trusted_length,
        )

    def __call__(self, separation: Floats) -> Floats:
        """The index at `separation` [m], any shape."""
        r = np.maximum(separation, NEARLY_ZERO)
        spread = self._spread(r)
        decay = self._log_reception(r) - self._reach * spread
        if self._weight is not None:
            decay = self._weight * decay
        value = self._value(decay, spread)[0]
        return value if self._divisor is None else value / self._divisor

    def parabola(self, separation: Floats) -> tuple[Floats, Floats, Floats]:
        """The index at `separation` [m], any shape, its slope [1/m] and half its second derivative [1/m^2].

        Where LEAST bounds the exponent, only 1 - e^-A has a slope.
        """
        shape, r = self._objective.shape_exponent, np.maximum(separation, NEARLY_ZERO)
        spread = self._spread(r)
        reception, loss, bend = self._reception(r)
        reach = self._reach * spread
        if self._weight is not None:
            reception, loss, bend, reach = (self._weight * part for part in (reception, loss, bend, reach))
        decay = reception - reach
        value, rise = self._value(decay, spread)
        is_flat = decay <= LEAST
        if np.logical_or.reduce(is_flat, axis=None):
            reach, loss, bend = (np.where(is_flat, 0.0, part) for part in (reach, loss, bend))
        # r (ln S)' = s (f - q A) with f = A/(e^A - 1), and r f' = s f (1 - A/(1 - e^-A))
        turn = spread / rise
        fall = turn * (1.0 - rise)
        slope = (shape * (fall - reach) + loss) / r
        second = (shape * (shape * (fall * (1.0 - turn) - reach) - fall + reach) + bend) / (r * r)
        if not self._is_log:
            second = value * (second + slope * slope)
            slope = value * slope
        if self._divisor is not None:
            value, slope, second = (part / self._divisor for part in (value, slope, second))
        return value, slope, 0.5 * second

    def trusted(self, separation: Floats) -> Floats:
        """Length [m] on both sides of `separation` [m] over which the parabola counts."""
        far = self._trusted_share * separation
        return np.minimum(far, self._trusted_length) if self._trusted_length < np.inf else far

    def _spread(self, r: Floats) -> Floats:
        """A, between its bounds."""
        spread = elementary.power(r / self._objective.minimum_separation, self._objective.shape_exponent)
        return np.minimum(np.maximum(spread, LEAST_SPREAD), MOST_SPREAD)

    def _value(self, decay: Floats, spread: Floats) -> tuple[Floats, Floats]:
        """The index, and 1 - e^-A."""
        if self._is_log:
            rise = elementary.one_minus_exp(spread)
            return np.maximum(decay, LEAST) + elementary.log(rise), rise
        fall, rise = elementary.exp_and_rise(decay, spread)
        return fall * rise, rise

    def _log_reception(self, r: Floats) -> Floats:
        """ln p."""
        if self._channel.model == "logistic":
            return -elementary.log_sum_exp(outage.logistic_excess(r, self._channel))
        if self._loss == 0.0:
            return np.zeros_like(r)
        return -self._loss * elementary.power(r, self._channel.path_loss_exponent)

    def _reception(self, r: Floats) -> tuple[Floats, Floats, Floats]:
        """ln p, r (ln p)' and r^2 (ln p)''; ln p is bounded where the index is flat, so that all three are finite."""
        log = np.maximum(self._log_reception(r), 2.0 * LEAST)
        if self._channel.model == "logistic":
            lost = outage.outage_probability(r, self._channel)
            per_width = r / self._channel.logistic_width
            loss = -lost * per_width
            return log, loss, loss * (1.0 - lost) * per_width
        exponent = self._channel.path_loss_exponent
        return log, exponent * log, exponent * (exponent - 1.0) * log


class OracleSeeking(PerturbationSeeking):
    """(18) with the index of the channel's formula."""

    Parameters = OracleConfig
    knows_channel = True

    def __init__(self, parameters: OracleConfig, context: LawContext) -> None:
        assert context.channel is not None
        channel, transform = context.channel.config, parameters.index_transform
        super().__init__(parameters, context, FormulaIndex(context.objective, channel, transform))
        self._weighted = partial(FormulaIndex, context.objective, channel, transform)

    def compiled_index(self) -> tuple[int, Any] | None:
        """The address of the compiled index, and its settings; None where numpy computes, and for other classes."""
        index = self.seeker.index
        if type(self) is not OracleSeeking or type(index) is not FormulaIndex:
            return None
        return formula_index.compiled(index.settings)

    def seek(self, state: Floats, around: Neighborhood) -> Floats:
        """One tick of (18), with the quality weights of the formation law.

        A change of a weight changes the sample, and the washout would take that for a slope. So the baseline changes
        by as much.
        """
        weight = around.link_quality_weight
        if weight is None:
            return self.climb(state[:WEIGHT], around, None)
        index = self._weighted(weight)
        before = state[WEIGHT] if len(state) > WEIGHT else np.ones_like(weight)
        moved = state[:WEIGHT].copy()
        if not np.array_equal(weight, before):
            time = around.tick * self.context.dt + self.context.skew(around.tick, around.links)
            place = moved[ESTIMATE] + link_estimates.dither(self.seeker.config, time)
            moved[BASELINE] += self.seeker.config.index_gain * (index(place) - self._weighted(before)(place))
        return np.concatenate([self.climb(moved, around, index), weight[None]])
