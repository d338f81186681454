"""What scenarios expect of their runs, and the exit code 2."""

import json
import subprocess
from pathlib import Path
from typing import Any

import pytest

from console import inprocess
from fes.errors import ScenarioError
from tests.loop import CONFIGS, load
from tests.test_processes import PATIENCE, fes
from world import expect
from world.expect import ExpectConfig

SUMMARY: dict[str, Any] = {
    "separation_error_rms": 0.4,
    "links_connected_always": True,
    "disagreement": None,
    "scenario": "pair",
    "time_to": {"level": 3.0},
    "tracking": [{"rmse": 1.0}, {"rmse": 2.0}],
}


@pytest.mark.parametrize(
    ("table", "holds"),
    [
        ({"of": "separation_error_rms", "below": 0.5}, True),
        ({"of": "separation_error_rms", "below": 0.4}, False),
        ({"of": "separation_error_rms", "above": 0.3, "below": 0.5}, True),
        ({"of": "separation_error_rms", "above": 0.4}, False),
        ({"of": "links_connected_always", "equals": True}, True),
        ({"of": "links_connected_always", "equals": False}, False),
        ({"of": "links_connected_always", "below": 2.0}, False),
        ({"of": "scenario", "equals": "pair"}, True),
        ({"of": "disagreement", "below": 9.0}, False),
        ({"of": "time_to.no.such.key", "above": 0.0}, False),
        ({"of": "time_to.level", "below": 3.5}, True),
        ({"of": "tracking.1.rmse", "above": 1.5}, True),
        ({"of": "tracking.-1.rmse", "equals": 2.0}, True),
        ({"of": "tracking.2.rmse", "above": 0.0}, False),
    ],
)
def test_an_expectation_holds_if_all_its_bounds_do(table: dict[str, Any], holds: bool) -> None:
    [verdict] = expect.verdicts([ExpectConfig.model_validate(table)], SUMMARY)
    assert verdict["holds"] is holds


def test_an_expectation_without_a_bound_is_refused_in_one_line() -> None:
    with pytest.raises(ScenarioError, match="give at least one of below, above and equals"):
        load("pair.toml", expect=[{"of": "separation_error_rms"}])


def test_a_key_that_no_summary_has_is_refused_in_one_line_with_the_nearest_one() -> None:
    with pytest.raises(ScenarioError, match=r"no 'separation_eror_rms'; did you mean 'separation_error_rms'\?$"):
        load("pair.toml", expect=[{"of": "separation_eror_rms", "below": 1.0}])
    with pytest.raises(ScenarioError, match=r"no 'no\\nsuch'$"):
        load("pair.toml", expect=[{"of": "no\nsuch.key", "below": 1.0}])


def test_a_summary_has_the_keys_that_can_be_expected_and_no_others() -> None:
    found = inprocess.run(load("pair.toml", run__duration=0.1), "keys")
    assert set(found) == {*expect.KEYS, "expectations"}


def test_the_summary_counts_how_long_links_were_apart() -> None:
    gone = [{"at": 4.0, "kill": [4]}]
    what = load("neighborhood.toml", run__duration=8, event=gone, expect=[{"of": "links_gap_longest", "below": 3.0}])
    found = inprocess.run(what, "gap")
    # peers let go of robot 4 after the timeout of a second, and link up anew about then
    assert 0.0 < found["links_gap_longest"] < 3.0
    assert found["expectations"] == [
        {"of": "links_gap_longest", "expected": "below 3.0", "seen": found["links_gap_longest"], "holds": True}
    ]
    assert not expect.unmet(found)


@pytest.mark.parametrize("backend", ["inprocess", "processes"])
def test_a_run_that_is_not_as_expected_exits_with_two_and_shows_what_was_seen(backend: str, tmp_path: Path) -> None:
    words = ["run", str(CONFIGS / "pair.toml"), "--duration", "1", "--headless", "--backend", backend]
    wish = 'expect=[{of="ticks", equals=50}, {of="estimate_error_max", below=1e-9}]'
    done = subprocess.run(fes(*words, "--set", wish), cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE)
    assert (done.returncode, done.stderr) == (2, "")
    lines = done.stdout.splitlines()
    assert any("ticks" in line and "equal to 50" in line and "holds" in line for line in lines)
    assert any("estimate_error_max" in line and "does not hold" in line for line in lines)
    kept = json.loads((tmp_path / "runs/latest/summary.json").read_text())
    assert [verdict["holds"] for verdict in kept["expectations"]] == [True, False]
