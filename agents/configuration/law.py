"""Marks and plans: how a team takes up one configuration, and takes it up again when robots die or join.

Once per period, each robot marks where it will be when the next period begins. The marks flood through the beacons.
Then each robot makes the same plan of the same marks, and all go straight to their goals at one common rate. The law
knows nothing of the channel: the spacing is the mean of the estimates that the seeking law gives.
"""

from dataclasses import dataclass, replace

import numpy as np

from agents.configuration import approach, planning, table
from agents.configuration.approach import Approach
from agents.configuration.clock import Clock, Reading
from agents.configuration.exchange import EMPTY, MOST, Exchange
from agents.configuration.planning import Plan, Settings
from agents.configuration.table import NOW, Table
from fes.arrays.types import Bools, Floats, Ints
from fes.extension.context import LawContext
from fes.extension.neighborhood import LinkGeometry, Neighborhood
from fes.extension.protocols import Formed
from fes.model.config import FormationConfig
from fes.shapes.choice import shape

UNKNOWN = -2
"""Stands for a period, a tick or an id that does not exist yet. It is below -1, so that no period follows it."""

SAFE = 5.0
"""Separation that contractions keep where the settings ask for none [m]."""

LISTENING = 10
"""Ticks for which a robot that starts during a run listens, beside those in which a peer relays all marks. Such a
robot may have marked this period before its restart."""


@dataclass(frozen=True, eq=False)
class State:
    """The state of a crew of n robots."""

    epoch: Ints
    """Period of each robot's clock [n]; UNKNOWN before its first tick."""
    listening: Ints
    """Tick from which a robot listens before its first mark [n]; UNKNOWN if it does not."""
    estimate: Floats
    """Mean of each robot's estimates, the last one if it has no link [n] [m]; NaN before its first link."""
    table: Table
    relayed: Ints
    """The last id that each robot relayed [n]."""
    plans: tuple[Plan | None, ...]
    """The plan of each robot; None before its first one."""
    approach: Approach


class MarksAndPlans:
    """The formation law of a configuration."""

    Parameters = FormationConfig
    details = ("slot", "plan")
    """The robot's slot (-1: none), and the kind of its plan (0 direct, 1 contraction, 2 none yet)."""

    def __init__(self, parameters: FormationConfig, context: LawContext) -> None:
        self._config, self._context, self._objective = parameters, context, context.objective
        self._n, self._own = len(context.ids), context.draws.own_ids(context.ids)
        name = "lattice" if parameters.configuration == "none" else parameters.configuration
        self._settings = Settings(
            name,
            tuple(parameters.offsets),
            self._objective.losses,
            parameters.orientations,
            parameters.keep_range,
            planning.CLEARANCE * (parameters.safe_separation or SAFE),
        )
        self._clock = Clock(context, parameters.plan_period)
        limit = parameters.linear_limit
        farthest = None if limit is None else limit * self._clock.period
        self._most = min(MOST, len(parameters.offsets)) if name == "offsets" else MOST
        self._exchange = Exchange(
            context.ids, context.draws.own_ids, parameters.marks_per_beacon, self._most, farthest
        )
        self.declared = self._exchange.size

    def start(self) -> State:
        """No mark and no plan."""
        n = self._n
        unknown = np.full(n, UNKNOWN)
        blank = table.empty(n, self._own)
        return State(unknown, unknown, np.full(n, np.nan), blank, unknown, (None,) * n, approach.none(n))

    def forget(self, state: State, restarted: Bools) -> State:
        """The state in which the robots `restarted` [n] know no mark and have no plan."""
        return State(
            np.where(restarted, UNKNOWN, state.epoch),
            np.where(restarted, UNKNOWN, state.listening),
            np.where(restarted, np.nan, state.estimate),
            table.forget(state.table, restarted),
            np.where(restarted, UNKNOWN, state.relayed),
            tuple(None if is_new else plan for is_new, plan in zip(restarted.tolist(), state.plans, strict=True)),
            approach.where(restarted, approach.none(self._n), state.approach),
        )

    def step(self, state: State, around: Neighborhood, links: LinkGeometry) -> Formed:
        """The pull of each robot toward its goal."""
        clock, positions = self._clock.read(around.tick), around.poses[:, :2]
        state = replace(state, estimate=_mean_estimate(state.estimate, around, links))
        state = replace(state, table=self._exchange.hear(state.table, state.epoch, around))

        # a period begins: the plan of the last period's marks, then the mark of this one
        before = state.epoch
        if not np.array_equal(clock.epoch, before):
            state = self._turn(state, clock, around.tick)
        state = self._mark(state, clock, around.tick, positions, clock.epoch == before + 1)

        message, relayed = self._exchange.send(state.table, state.epoch, state.relayed)
        pull = approach.pull(state.approach, positions, clock.time, self._context.dither, self._config.linear_gain)
        details = np.stack([state.approach.slot, state.approach.kind], axis=1).astype(np.float64)
        return Formed(
            replace(state, relayed=relayed), pull, message, details, quality_weight=self._quality_weight(state)
        )

    def _turn(self, state: State, clock: Reading, tick: int) -> State:
        """The state in which each robot has the period of its clock. One that enters the next period plans."""
        periods = clock.epoch - state.epoch
        is_first = state.epoch == UNKNOWN
        is_planning = ~is_first & (periods == 1) & self._has_own(state.table)
        plans, now = list(state.plans), state.approach
        if is_planning.any():
            for row in np.flatnonzero(is_planning).tolist():
                ids, marks = state.table.known(row)
                plans[row] = planning.plan(ids.tobytes(), marks.tobytes(), self._settings)
            now = approach.where(is_planning, self._approach(plans, is_planning, clock.time), now)
        # a robot that starts during a run, or whose clock was set back, may have marked this period before
        is_late = (is_first & (tick > 0)) | (~is_first & (periods < 0))
        listening = np.where(is_late, tick, np.where(periods > 0, UNKNOWN, state.listening))
        return replace(
            state,
            epoch=clock.epoch.copy(),
            listening=listening,
            table=table.advance(state.table, np.where(is_first, 2, periods)),
            plans=tuple(plans),
            approach=now,
        )

    def _approach(self, plans: list[Plan | None], is_planning: Bools, time: Floats) -> Approach:
        """The approaches of the robots where `is_planning` [n], by their `plans`, which begin at `time` [n] [s]."""
        result = approach.none(self._n)
        dither = approach.swing(self._context.dither, time)
        for row in np.flatnonzero(is_planning).tolist():
            plan = plans[row]
            assert plan is not None
            place = int(np.searchsorted(plan.ids, self._own[row]))
            result.kind[row], result.slot[row] = plan.kind, plan.slots[place]
            result.base[row], result.offset[row] = plan.bases[place], plan.offsets[place]
            result.spacing[row] = plan.spacing
            result.rate[row] = self._rate(plan.farthest(float(dither[row])))
            result.quality_weight[row] = self._weight(len(plan.ids))
        return result

    def _rate(self, farthest: float) -> float:
        """kappa [1/s], at which no robot of a plan is faster than the limit if the longest way is `farthest` [m]."""
        gain, limit = self._config.linear_gain, self._config.linear_limit
        return gain if limit is None or gain * farthest <= limit else limit / farthest

    def _mark(self, state: State, clock: Reading, tick: int, positions: Floats, is_new: Bools) -> State:
        """The state with the marks of robots that have none in this period, and need not listen for an old one.

        A robot without an estimate has never had a link, so no other robot would hear its mark.
        """
        is_missing = ~self._has_own(state.table) & np.isfinite(state.estimate) & (self._own < EMPTY)
        if not is_missing.any():
            return state
        heard = -(-state.table.counts(self._own) // self._config.marks_per_beacon)
        is_free = is_new | (state.listening == UNKNOWN) | (tick - state.listening >= LISTENING + heard)
        rows = np.flatnonzero(is_missing & is_free)
        if not len(rows):
            return state
        limit, dither = self._config.linear_limit, self._context.dither
        places = approach.predicted(state.approach, positions, clock.time, self._clock.period, dither, limit)
        marks = np.concatenate([places, state.estimate[:, None]], axis=1)[rows]
        return replace(state, table=table.with_own(state.table, rows, self._own[rows], marks))

    def _has_own(self, known: Table) -> Bools:
        """True for a robot that knows its own mark of the present period [n]."""
        result: Bools = known.is_known[NOW, np.arange(self._n), known.columns(self._own)]
        return result

    def _quality_weight(self, state: State) -> Floats:
        """beta [n] [1]: of the plan's shape, or before the first plan, of the number of ids that a robot knows."""
        result = state.approach.quality_weight
        rows = np.flatnonzero(state.approach.kind == planning.NONE)
        if len(rows):
            result, number = result.copy(), np.minimum(state.table.counts(self._own), self._most)
            result[rows] = [self._weight(_rounded(count)) for count in number[rows].tolist()]
        return result

    def _weight(self, n: int) -> float:
        """beta of the shape of `n` robots [1]."""
        settings = self._settings
        team = shape(settings.configuration, n, settings.losses, settings.offsets)
        return team.quality_weight(settings.losses, self._objective.coverage_weight)


def _rounded(n: int) -> int:
    """A number of robots, rounded down to five bits: the weights of all large teams would take seconds to compute."""
    return n - n % (1 << max(0, n.bit_length() - 5))


def _mean_estimate(last: Floats, around: Neighborhood, links: LinkGeometry) -> Floats:
    """Mean of each robot's estimates over its links, or the last one [n] [m]."""
    edges = around.links
    return np.where(edges.counts > 0, edges.sum(links.estimates) / np.maximum(edges.counts, 1), last)
