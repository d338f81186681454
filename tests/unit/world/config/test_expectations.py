"""Expectations of a scenario: verdicts, impossible expectations, and the exit code 2."""

import math
from typing import Any

import pytest

from console.backends import inprocess
from fes.errors import ScenarioError
from tests.support.loop import load
from world.config import expectations
from world.config.expectations import ExpectConfig

SUMMARY: dict[str, Any] = {
    "separation_error_rms": 0.4,
    "links_connected_always": True,
    "disagreement": None,
    "scenario": "pair",
    "time_to": {"estimate_1m": 3.0, "separation_1m": None},
    "tracking": [{"rmse": 1.0}, {"rmse": 2.0}],
    "deadlines": None,
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
        ({"of": "scenario", "equals": "pair"}, True),
        ({"of": "disagreement", "below": 9.0}, False),
        ({"of": "deadlines.missed.0", "below": 9.0}, False),
        ({"of": "time_to.separation_1m", "below": 9.0}, False),
        ({"of": "time_to.estimate_1m", "below": 3.5}, True),
        ({"of": "tracking.1.rmse", "above": 1.5}, True),
        ({"of": "tracking.-1.rmse", "equals": 2.0}, True),
        ({"of": "tracking.2.rmse", "above": 0.0}, False),
    ],
)
def test_an_expectation_holds_if_all_its_bounds_do(table: dict[str, Any], holds: bool) -> None:
    [verdict] = expectations.verdicts([ExpectConfig.model_validate(table)], SUMMARY)
    assert verdict["holds"] is holds


def test_an_expectation_without_a_bound_is_rejected_in_one_line() -> None:
    with pytest.raises(ScenarioError, match="give at least one of below, above and equals"):
        load("pair.toml", expect=[{"of": "separation_error_rms"}])


def test_an_unknown_key_is_rejected_in_one_line_with_the_nearest_one() -> None:
    with pytest.raises(ScenarioError, match=r"no 'separation_eror_rms'; did you mean 'separation_error_rms'\?$"):
        load("pair.toml", expect=[{"of": "separation_eror_rms", "below": 1.0}])
    with pytest.raises(ScenarioError, match=r"no 'no\\nsuch'$"):
        load("pair.toml", expect=[{"of": "no\nsuch.key", "below": 1.0}])


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ({"of": "time_to.estimte_1m", "below": 5.0}, "no 'time_to.estimte_1m'; did you mean 'time_to.estimate_1m'?"),
        ({"of": "time_to.\n", "below": 5.0}, "no 'time_to.\\n'"),
        ({"of": "deadlines.mised_share", "below": 0.1}, "did you mean 'deadlines.missed_share'?"),
        ({"of": "tracking.0.rms", "below": 0.1}, "did you mean 'tracking.0.rmse'?"),
        (
            {"of": "tracking.rmse", "below": 0.1},
            "'tracking' is a list: give the index of an entry, from 0, got 'rmse'",
        ),
        ({"of": "tracking.²", "below": 0.1}, "got '²'"),
        ({"of": "edges.0.5", "below": 0.1}, "'edges.0' has 5 entries, no '5'"),
        ({"of": "ticks.0", "equals": 5.0}, "'ticks' is a number, and has no '0'"),
        ({"of": "ticks.", "equals": 5.0}, "'ticks' is a number, and has no ''"),
        ({"of": "edges", "below": 5.0}, "'edges' is not a single value: name one in it, such as 'edges.0.0'"),
        ({"of": "time_to", "below": 5.0}, "such as 'time_to.disagreement_1m'"),
        ({"of": "tracking.1", "equals": 5.0}, "such as 'tracking.1.at'"),
        ({"of": "disk_connected_always", "below": 5.0}, "'disk_connected_always' is true or false: give equals"),
        ({"of": "digest", "above": 5.0}, "'digest' is a text: give equals"),
        ({"of": "digest", "equals": 5.0}, "never equal to 5.0"),
        ({"of": "ticks", "equals": "5"}, "never equal to '5'"),
        ({"of": "ticks", "equals": math.nan}, "never equal to nan"),
        ({"of": "disk_connected_always", "equals": 2.0}, "never equal to 2.0"),
        ({"of": "ticks", "above": 5.0, "below": 5.0}, "no value is above 5.0 and below 5.0"),
        ({"of": "ticks", "above": 5.0, "equals": 4.0}, "no value is above 5.0 and equal to 4.0"),
    ],
)
def test_an_impossible_expectation_is_rejected_at_the_start_in_one_line(table: dict[str, Any], said: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        load("pair.toml", expect=[table])
    assert said in str(caught.value)
    assert str(caught.value).isprintable()


def test_the_summary_has_the_longest_gap_of_the_links() -> None:
    gone = [{"at": 4.0, "kill": [4]}]
    scenario = load(
        "neighborhood.toml", run__duration=8, event=gone, expect=[{"of": "links_gap_longest", "below": 3.0}]
    )
    summary = inprocess.run(scenario, "gap")
    # peers drop robot 4 after the timeout of a second, and form new links about then
    assert 0.0 < summary["links_gap_longest"] < 3.0
    assert summary["expectations"] == [
        {"of": "links_gap_longest", "expected": "below 3.0", "seen": summary["links_gap_longest"], "holds": True}
    ]
    assert not expectations.unmet(summary)


def test_deadlines_are_expected_of_a_live_clock_only() -> None:
    wanted = [{"of": "deadlines.missed_share", "below": 0.1}]
    assert load("pair.toml", run__clock="live", expect=wanted).expect
    with pytest.raises(ScenarioError, match=r"'deadlines.missed_share' exists with a live clock only"):
        load("pair.toml", expect=wanted)
