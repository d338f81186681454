"""Teams that count beacons while two robots die and one joins: `python -m tests.support.measured_deaths --runs 14`.

The product runs in one loop: ten robots from a medium start, two random ones die at DEATHS, and another one joins at
JOINER, 20 to 100 m off the patch. F is over the target of as many robots as are present.
"""

import argparse
from dataclasses import dataclass

import numpy as np

from tests.support.configuration_runs import with_events
from tests.support.measured_teams import EVERY, Measured, of, watch

DEATHS, JOINER, DURATION = 120.7, 150.7, 300.0
"""Times of the events, and of the end [s]."""

SETTLED = 40.0
"""Time after an event within which the team settles [s]."""

STEP = 0.02
"""Length of a tick [s]."""


@dataclass(frozen=True)
class Answer:
    """The answer of a team to an event."""

    least: float
    """Least F over its target."""
    back: float
    """Time after which F stays at 95 % of its target [s]."""
    error: float
    """Largest error of the mean estimate against r_beta of as many robots [m]."""


def answer(run: Measured, event: float, end: float) -> Answer:
    """The answer to the event at `event` [s], until `end` [s]."""
    first, last = (round(time / STEP / EVERY) + 1 for time in (event, end))
    share = run.share[first:last]
    below = np.flatnonzero(share < 0.95)
    back = STEP * EVERY * (first + int(below[-1]) + 1) - event if len(below) else 0.0
    errors = np.abs(run.error[round(event / STEP) + 1 : round(end / STEP)])
    return Answer(float(share.min()), back, float(np.nanmax(errors)))


def line(name: str, answers: list[Answer]) -> str:
    """One line of the table: medians and worst cases."""
    least, back, error = (np.array([getattr(a, field) for a in answers]) for field in ("least", "back", "error"))
    cells = (
        name,
        len(answers),
        f"{np.median(least):.3f} ({least.min():.3f})",
        f"{np.median(back):.1f} / {back.max():.1f}",
        f"{np.median(error):.2f} / {error.max():.2f}",
    )
    return " | ".join(map(str, cells))


def main() -> None:
    """Print a line for each event, and one for the end."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=14)
    parser.add_argument("--amplitude", type=float, default=3.0)
    given = parser.parse_args()
    runs = [
        watch(with_events(of("medium", seed, DURATION, given.amplitude), DEATHS, 2, 1, JOINER))
        for seed in range(1, given.runs + 1)
    ]
    print("event", "runs", "least F (worst)", "F >= .95 [s]", "largest error [m]", sep=" | ")
    print(line("two die", [answer(run, DEATHS, JOINER) for run in runs]))
    print(line("one joins", [answer(run, JOINER, JOINER + SETTLED) for run in runs]))
    tails = [run.error[round((JOINER + SETTLED) / STEP) :] for run in runs]
    shares = [run.share[round((JOINER + SETTLED) / STEP / EVERY) :] for run in runs]
    rmse, mean = np.sqrt(np.mean([tail**2 for tail in tails])), np.mean(shares)
    averaged, cut = min(run.averaged for run in runs), sum(run.cut_heard for run in runs)
    print(f"afterwards: rmse {rmse:.3f} m, F {mean:.4f}, of averages at least {averaged:.5f}")
    print(f"ticks whose links did not connect the team: {cut}")


if __name__ == "__main__":
    main()
