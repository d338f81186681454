"""summary.json and scenario.toml, which scripts outside the project read."""

import json
import math
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from console.backends import inprocess
from fes.errors import FesError
from tests.support import loop
from tests.support import reference as witness
from tests.support.paths import CONFIGS
from tests.support.results import written
from world.config import scenario
from world.metrics import summary

CONTRACT = {
    "scenario": str,
    "seed": int,
    "backend": str,
    "clock": str,
    "robots": int,
    "ticks": int,
    "dt": float,
    "simulated_s": float,
    "wall_s": float,
    "ticks_per_s": float,
    "real_time_factor": float,
    "optimal_separation": float,
    "edges": list,
    "separation_error_max": float,
    "separation_error_rms": float,
    "disagreement": float,
    "estimate_error_max": float,
    "estimate_error_rms": float,
    "disk_connected_always": bool,
    "links_connected_always": bool,
    "algebraic_connectivity": float,
    "beacons_sent": int,
    "beacons_decoded": int,
    "time_to": dict,
    "digest": str,
    "tracking": list,
    "radio": list,
    "deadlines": type(None),
    "arithmetic": dict,
    "links_gap_longest": float,
    "unscheduled_absences": int,
    "links_lost_at": type(None),
    "smallest_separation": float,
    "model_free": type(None),
    "metrics": dict,
    "expectations": list,
}
"""The keys of the contract, and their types in a run that has links."""

TIMES = {"disagreement_1m", "estimate_1m", "estimate_0_1m", "separation_1m", "separation_0_1m"}
ERRORS = ("separation_error", "estimate_error")
OF_LINKS = (*(f"{error}_{kind}" for error in ERRORS for kind in ("max", "rms")), "disagreement")


def rms(errors: list[float]) -> float:
    return math.sqrt(sum(error * error for error in errors) / len(errors))


@pytest.mark.parametrize("name", ["paper.toml", "pair.toml", "neighborhood.toml"])
def test_the_summary_has_the_keys_and_types_of_the_contract(name: str, tmp_path: Path) -> None:
    run_summary = written(tmp_path, inprocess.run(loop.load(name, run__duration=2), name))
    assert {key: type(value) for key, value in run_summary.items()} == CONTRACT
    assert set(run_summary["time_to"]) == TIMES
    assert {type(time) for time in run_summary["time_to"].values()} <= {float, type(None)}
    assert len(bytes.fromhex(run_summary["digest"])) == 32
    assert list(run_summary) == list(CONTRACT)


def test_a_run_without_links_has_null_for_undefined_numbers(tmp_path: Path) -> None:
    alone = loop.load("pair.toml", run__duration=0.5, channel__communication_range=10.0)
    run_summary = written(tmp_path, inprocess.run(alone, "pair"))
    assert set(run_summary) == set(CONTRACT)
    assert run_summary["edges"] == []
    assert [run_summary[key] for key in OF_LINKS] == [None] * 5
    assert set(run_summary["time_to"].values()) == {None}
    assert run_summary["disk_connected_always"] is False
    assert (run_summary["algebraic_connectivity"], run_summary["beacons_sent"], run_summary["beacons_decoded"]) == (
        0.0,
        0,
        0,
    )


@pytest.mark.parametrize(("name", "seconds"), [("paper.toml", 2), ("paper.toml", 0.1), ("neighborhood.toml", 3)])
def test_the_edges_are_those_of_the_last_tick_with_their_separations_and_both_estimates(
    name: str, seconds: float
) -> None:
    configured = loop.load(name, run__duration=seconds)
    run_summary, history = inprocess.run(configured, name), loop.run(configured)
    estimates = history.estimates[-1]
    pairs = sorted(history.edges(-1))
    assert len(pairs) > 5
    assert [(i, j) for i, j, *_ in run_summary["edges"]] == pairs
    for i, j, separation, mine, theirs in run_summary["edges"]:
        assert separation == pytest.approx(history.separation(-1, (i, j)), abs=1e-9)
        assert (mine, theirs) == (estimates.get((i, j)), estimates.get((j, i)))


def test_a_link_that_only_one_robot_uses_has_null_for_the_other() -> None:
    history = loop.run(loop.load("paper.toml"), 150)
    tick, (i, j) = next(
        (tick, pair)
        for tick, estimates in enumerate(history.estimates)
        for pair in sorted(estimates)
        if (pair[1], pair[0]) not in estimates
    )
    run_summary = inprocess.run(loop.load("paper.toml", run__duration=(tick + 1) * 0.02), "paper")
    estimates = history.estimates[tick][i, j]
    row = next(row for row in run_summary["edges"] if row[:2] == [min(i, j), max(i, j)])
    assert row[3:] == ([estimates, None] if i < j else [None, estimates])


def test_the_errors_are_those_of_the_edges() -> None:
    run_summary = inprocess.run(loop.load("paper.toml", run__duration=2), "paper")
    best = run_summary["optimal_separation"]
    assert best == pytest.approx(witness.OPTIMUM_50, abs=1e-5)
    separation = [row[2] - best for row in run_summary["edges"]]
    estimate = [value - best for row in run_summary["edges"] for value in row[3:] if value is not None]
    apart = [abs(row[3] - row[4]) for row in run_summary["edges"] if None not in row]
    expected = {
        "separation_error_max": max(map(abs, separation)),
        "separation_error_rms": rms(separation),
        "disagreement": sum(apart),
        "estimate_error_max": max(map(abs, estimate)),
        "estimate_error_rms": rms(estimate),
    }
    assert {key: run_summary[key] for key in OF_LINKS} == pytest.approx(expected, rel=1e-12)


def test_the_counts_of_a_pair_with_a_perfect_radio_are_those_computed_by_hand() -> None:
    run_summary = inprocess.run(loop.load("pair.toml", run__duration=2, channel__model="perfect"), "pair")
    assert (run_summary["robots"], run_summary["ticks"], run_summary["simulated_s"], run_summary["seed"]) == (
        2,
        100,
        2.0,
        1,
    )
    # Each of the ticks 2 to 99 reports two beacons
    assert run_summary["beacons_sent"] == run_summary["beacons_decoded"] == 2 * 98
    assert run_summary["links_connected_always"] is True  # from tick 2 on: no robot can have a link before
    assert run_summary["algebraic_connectivity"] == pytest.approx(2.0)  # the Laplacian [[1, -1], [-1, 1]]
    assert run_summary["ticks_per_s"] == pytest.approx(100 / run_summary["wall_s"])
    assert run_summary["real_time_factor"] == pytest.approx(2.0 / run_summary["wall_s"])


def test_the_summary_is_complete_before_it_replaces_the_old_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    summary.write(tmp_path, {"run": "old"})
    replace, seen = os.replace, []

    def watched(source: Path, target: Path) -> None:
        seen.append((Path(target), json.loads(Path(source).read_text()), json.loads(Path(target).read_text())))
        replace(source, target)

    monkeypatch.setattr(os, "replace", watched)
    summary.write(tmp_path, {"run": "new"})
    assert seen == [(tmp_path / "summary.json", {"run": "new"}, {"run": "old"})]
    assert [path.name for path in tmp_path.iterdir()] == ["summary.json"]


def test_a_summary_that_cannot_be_written_leaves_the_old_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    summary.write(tmp_path, {"run": "old"})
    with pytest.raises(TypeError):
        summary.write(tmp_path, {"run": object()})

    def half(path: Path, text: str, encoding: str) -> None:
        with path.open("w") as stream:
            stream.write(text[: len(text) // 2])
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_text", half)
    with pytest.raises(FesError, match="No space"):
        summary.write(tmp_path, {"run": "new"})
    assert json.loads((tmp_path / "summary.json").read_text()) == {"run": "old"}


@pytest.mark.parametrize("name", [path.name for path in sorted(CONFIGS.glob("*.toml"))])
@pytest.mark.parametrize(
    "overrides",
    [
        {},
        {
            "run__dt": 1 / 7,
            "run__seed": 2**63 - 1,
            "formation__linear_limit": 7.5,
            "formation__plan_period": 100 / 7,
        },
        {
            "channel__reference_snr": 12345678.901234567,
            "objective__maximum_separation": 1e300,
            "formation__contact_timeout": 1e-5,
        },
        {"robots": {"count": 7, "kind": "line", "jitter": 0.1}, "seeking": {}, "objective": {}, "event": []},
    ],
)
def test_the_scenario_in_a_run_directory_is_the_one_that_was_run(
    name: str, overrides: dict[str, Any], tmp_path: Path
) -> None:
    ran = loop.load(name, **overrides)
    summary.write_scenario(tmp_path, ran)
    again = scenario.load(tmp_path / "scenario.toml")
    assert again == ran
    assert np.array_equal(scenario.initial_poses(again), scenario.initial_poses(ran))


def test_the_smallest_separation_is_that_of_all_ticks_and_of_robots_that_are_present() -> None:
    # Robot 0 drives past robot 2, at 3 m; where robot 2 dies before, only its way until then counts.
    changes = {
        "run__duration": 6.0,
        "robots__poses": [[0.0, 0.0, 0.0], [0.0, 90.0, 0.0], [10.0, 3.0, 0.0]],
        "seeking": {"use": "fixed_separation"},
        "formation__law": {"use": "goals", "goals": [[80.0, 0.0], [0.0, 90.0], [10.0, 3.0]]},
        "formation__linear_limit": 5.0,
    }
    for event, seen in (([], (0, 300)), ([{"at": 1.0, "kill": [2]}], (0, 50))):
        configured = loop.load("pair.toml", event=event, **changes)
        history = loop.run(loop.load("pair.toml", **changes))  # robot 2 stands still in either case
        expected = min(history.separation(tick, (0, 2)) for tick in range(*seen))
        assert inprocess.run(configured, "x")["smallest_separation"] == pytest.approx(expected, rel=1e-12)
        assert (expected < 3.1) == (not event)


def test_a_robot_alone_has_no_smallest_separation() -> None:
    alone = loop.load("pair.toml", run__duration=0.1, robots__poses=[[0.0, 0.0, 0.0]])
    assert inprocess.run(alone, "x")["smallest_separation"] is None
