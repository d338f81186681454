"""Runs that share one array program keep the digits that each has alone."""

import pytest

from console.backends import stacked
from console.sweep import work
from console.sweep.design import SweepRun
from tests.support.loop import load
from tests.support.results import alone, without_wall_clock
from world.config.scenario import Scenario


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "duration"),
    [("paper.toml", 12.0), ("measured.toml", 4.0), ("neighborhood.toml", 3.0), ("paper-as-printed.toml", 3.0)],
)
def test_a_stacked_run_has_the_summary_and_digest_of_a_single_run(name: str, duration: float) -> None:
    scenarios = [load(name, run__seed=seed, run__duration=duration) for seed in (3, 0, 12)]
    result = [without_wall_clock(summary) for summary in stacked.run(scenarios, "x")]
    assert len({summary["digest"] for summary in result}) == 3
    assert result == alone(scenarios)


def test_runs_with_different_teams_and_different_channels_can_share_a_stack() -> None:
    small = {"seeking__index": "measured", "run__duration": 2.0, "robots__jitter": 5.0}
    scenarios = [
        load("hundred.toml", robots__count=7, **small),
        load("hundred.toml", robots__count=1, **small),
        load("hundred.toml", robots__count=4, channel__path_loss_exponent=2.8, **small),
    ]
    assert len({repr(stacked.alike(scenario)) for scenario in scenarios}) == 1
    assert [without_wall_clock(summary) for summary in stacked.run(scenarios, "x")] == alone(scenarios)


def runs(*scenarios: Scenario) -> list[SweepRun]:
    return [SweepRun(cell, seed, scenario) for cell, scenario in enumerate(scenarios) for seed in range(10)]


def test_only_runs_with_equal_settings_of_their_robots_share_a_batch() -> None:
    planned = runs(load("pair.toml"), load("pair.toml", formation__rule="disk"), load("pair.toml", run__duration=9.0))
    for batch in work.batches("pair", planned, 2):
        assert len({repr(stacked.alike(scenario)) for scenario in batch.scenarios}) == 1


@pytest.mark.parametrize("workers", [1, 2, 3, 7, 40])
def test_batches_hold_every_run_once_and_keep_all_workers_equally_busy(workers: int) -> None:
    planned = runs(*(load("pair.toml", robots__jitter=float(jitter)) for jitter in range(5)))
    sizes = [len(batch.keys) for batch in work.batches("pair", planned, workers)]
    assert sum(sizes) == len(planned) == 50
    assert max(sizes) - min(sizes) <= 1
    assert max(sizes) <= work.MOST_RUNS
    assert len(sizes) % workers == 0


def test_a_large_team_is_not_stacked() -> None:
    batches = work.batches("hundred", runs(load("hundred.toml", robots__count=300)), 2)
    assert {len(batch.keys) for batch in batches} == {1}


def test_a_failed_run_does_not_stop_the_others_of_its_stack() -> None:
    # A single link weighs 1/2, and the square of half an estimate beyond 2.7e154 m is not finite. Of seed 1 both
    # estimates begin below that (and then out of reach of each other), of seed 0 one does not.
    scenarios = [
        load(
            "pair.toml",
            run__duration=1.0,
            run__seed=seed,
            seeking__index="measured",
            seeking__initial_estimate=[1.0, 4e154],
        )
        for seed in (1, 0)
    ]
    assert len({repr(stacked.alike(scenario)) for scenario in scenarios}) == 1
    near, far = work.carry_out(work.Batch("pair", ("near", "far"), tuple(scenarios)))
    assert (near.key, near.error, near.scalars["ticks"]) == ("near", None, 50)
    assert (far.key, far.scalars) == ("far", {})
    assert far.error is not None


def test_an_error_of_a_run_is_kept_with_its_reason() -> None:
    wild = load("pair.toml", run__duration=1.0, seeking__index_gain=1e308)
    (done,) = work.carry_out(work.Batch("pair", ("wild",), (wild,)))
    assert done.scalars == {}
    assert done.error is not None
    assert "not finite" in done.error
