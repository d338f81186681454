"""Teams that count beacons and take up a configuration: `python -m tests.support.measured_teams paper --runs 20`.

The product runs in one loop. Per run, from 60 s on unless said otherwise: time until the mean estimate is within 1 m
of r_beta permanently; its bias and rmse; F over its target, at each sample and of positions averaged over a dither
period; links; ticks in which the links in use did not connect the robots; changes of slots after the first plan.
"""

import argparse
import json
from dataclasses import dataclass
from typing import Any

import numpy as np

from console.backends import inprocess
from fes.arrays.types import Floats
from fes.extension.context import WorldContext
from tests.support.configuration_runs import scenario
from world.config.radio import RadioConfig
from world.config.scenario import Scenario
from world.metrics import graphs
from world.metrics.team import target
from world.metrics.team.progress import links_between
from world.simulation import reception

PERIOD = 1000
"""Ticks of a dither period."""

EVERY = 25
"""Ticks between two samples of the team index."""

BEGUN = 50
"""Tick from which the links must connect the robots: the first beacons must be heard first."""

SETTLED = 60.0
"""Time from which errors count [s]."""


@dataclass
class Measured:
    """The outcome of one run."""

    error: Floats
    """Mean estimate minus r_beta at each tick [m]; NaN without links."""
    share: Floats
    """F over its target, every EVERY ticks."""
    averaged: float
    """F over its target of the positions averaged over the last period."""
    links: int
    """Least number of directed links in use from SETTLED on."""
    cut_heard: int
    """Ticks after the first second in which the links in use did not connect the robots."""
    slot_changes: int
    """Slots that changed after the first plan, while no robot died or joined."""

    def within(self, error: float, first: int = 0) -> float:
        """Time after the tick `first` from which the error stays within `error` [m] [s]."""
        outside = np.flatnonzero(~(np.abs(self.error[first:]) <= error))
        return 0.02 * (int(outside[-1]) + 1 if len(outside) else 0)


def watch(run: Scenario) -> Measured:
    """The outcome of a run, in which the channel may change, and robots may die and join."""
    errors, shares, positions = [], [], []
    cut = changes = 0
    links, before, slots = 10**6, None, np.zeros(0)
    context = reception.context(run)
    for tick in inprocess.ticks(run):
        state, telemetry = tick.state, tick.telemetry
        n, used, channel = int(np.count_nonzero(state.present)), telemetry.links, state.channel
        best = target.sought_separation(run, channel, n)
        errors.append(telemetry.estimates.mean() - best if len(used) else np.nan)
        places = state.poses[state.present, :2]
        positions.append(places)
        if state.tick % EVERY == 0:
            shares.append(_share(run, channel, places, context))
        if state.tick >= SETTLED / run.run.dt:
            links = min(links, len(used))
        if state.tick >= BEGUN:
            cut += graphs.parts(state.present, *links_between(state, telemetry)) > 1
        now = telemetry.details[:, 0]
        if before is not None and np.array_equal(before, state.present):
            changes += int(np.count_nonzero((now != slots) & (slots >= 0)))
        before, slots = state.present, now
    last = [places for places in positions[-PERIOD:] if len(places) == len(positions[-1])]
    averaged = _share(run, channel, np.mean(last, axis=0), context)
    return Measured(np.array(errors), np.array(shares), averaged, links, cut, changes)


def _share(run: Scenario, channel: RadioConfig, places: Floats, context: WorldContext) -> float:
    """F of robots at `places` [n, 2] [m] over the target of as many, without shadowing and bursts."""
    index = target.of_positions(places, channel, context)
    assert index is not None
    return index.value / target.target(len(places), run.formation, channel, context)


HEADS = (
    "start", "runs", "to 1 m [s]", "bias [m]", "rmse (worst) [m]", "F mean", "F least", "F averaged mean / worst",
    "F >= .95 [s]", "links", "cut", "slot changes",
)  # fmt: skip


def line(name: str, outcomes: list[Measured], first: float = SETTLED) -> str:
    """One line of the table: medians and worst cases over the runs; errors count from `first` [s] on."""
    start, sample = round(first / 0.02), round(first / 0.02 / EVERY)
    to = np.array([outcome.within(1.0) for outcome in outcomes])
    tails = [outcome.error[start:] for outcome in outcomes]
    bias = np.array([tail.mean() for tail in tails])
    rmse = np.array([np.sqrt(np.mean(tail**2)) for tail in tails])
    shares = [outcome.share[sample:] for outcome in outcomes]
    least = np.array([share.min() for share in shares])
    averaged = np.array([outcome.averaged for outcome in outcomes])
    back = np.array([_last_below(outcome.share, 0.95) for outcome in outcomes])
    spread = bias.std(ddof=1) / np.sqrt(len(bias)) if len(bias) > 1 else np.nan
    cells = (
        name,
        len(outcomes),
        f"{np.median(to):.1f} / {to.max():.1f}",
        f"{bias.mean():+.3f} ± {spread:.3f}",
        f"{np.sqrt(np.mean(rmse**2)):.3f} ({rmse.max():.2f})",
        f"{np.mean([share.mean() for share in shares]):.4f}",
        f"{np.median(least):.3f} / {least.min():.3f}",
        f"{averaged.mean():.5f} / {averaged.min():.5f}",
        f"{np.median(back):.1f} / {back.max():.1f}",
        min(outcome.links for outcome in outcomes),
        sum(outcome.cut_heard for outcome in outcomes),
        sum(outcome.slot_changes for outcome in outcomes),
    )
    return " | ".join(map(str, cells))


def _last_below(share: Floats, bound: float) -> float:
    """Time from which the share stays at the bound or above [s]."""
    below = np.flatnonzero(share < bound)
    return 0.02 * EVERY * (int(below[-1]) + 1 if len(below) else 0)


def of(kind: str, seed: int, duration: float, amplitude: float, **settings: Any) -> Scenario:
    """The scenario of a start, with ten robots and a dither period of 20 s."""
    dither = {"seeking__dither_amplitude": amplitude, "seeking__dither_frequency": 2.0 * np.pi / 20.0}
    return scenario(kind, 10, seed, duration, "measured", **dither, **settings)


def main() -> None:
    """Print a line for each kind of start."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kinds", nargs="+")
    parser.add_argument("--runs", type=int, default=8)
    parser.add_argument("--first", type=int, default=1, help="seed of the first run")
    parser.add_argument("--duration", type=float, default=180.0)
    parser.add_argument("--amplitude", type=float, default=3.0)
    parser.add_argument("--snr-halved-at", type=float, nargs="*", default=[], help="a time for each run in turn [s]")
    parser.add_argument("--set", nargs="*", default=[], help="further settings, such as formation.plan_period=1.0")
    given = parser.parse_args()
    settings = {
        path.replace(".", "__"): json.loads(value) for path, _, value in (text.partition("=") for text in given.set)
    }
    print(*HEADS, sep=" | ", flush=True)
    for kind in given.kinds:
        outcomes, after, biases = [], [], []
        for seed in range(given.first, given.first + given.runs):
            times = given.snr_halved_at
            events = (
                {"event": [{"at": times[seed % len(times)], "set": {"channel.reference_snr": 5e6}}]} if times else {}
            )
            outcome = watch(of(kind, seed, given.duration, given.amplitude, **settings, **events))
            outcomes.append(outcome)
            if times:
                first = round(times[seed % len(times)] / 0.02)
                after.append(outcome.within(1.0, first))
                biases.append(outcome.error[first + 3000 :].mean())
        print(line(kind, outcomes), flush=True)
        if after:
            spread = f"{np.median(after):.1f} / {max(after):.1f} s"
            print(
                f"after the change: within 1 m in {spread}; bias from 60 s after {np.mean(biases):+.3f} m", flush=True
            )


if __name__ == "__main__":
    main()
