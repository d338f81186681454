"""The rules of a configuration and of its neighbor rule: each broken one is rejected in one line."""

from typing import Any

import pytest

from fes.errors import ScenarioError
from fes.model.config import TOLERANT
from world.config import remarks, scenario
from world.metrics.team import target

MEASURED = {"index": "measured", "dither_amplitude": 3.0, "dither_frequency": 0.3141592653589793}


def tables(formation: dict[str, Any], robots: int = 10, **others: Any) -> dict[str, Any]:
    return {
        "schema": 1,
        "robots": {"count": robots},
        "formation": {"configuration": "lattice", **formation},
        **others,
    }


def refusal(settings: dict[str, Any]) -> str:
    with pytest.raises(ScenarioError) as caught:
        scenario.parse(settings, "here")
    return str(caught.value)


@pytest.mark.parametrize(
    ("settings", "line"),
    [
        (
            tables({"plan_period": 0.8}),
            "here: formation.plan_period must be at least 4 x (robots / marks_per_beacon + 10) ticks, 0.9 s, got 0.8",
        ),
        (
            tables({"plan_period": 2.0}, robots=121),
            "here: formation.plan_period must be at least 4 x (robots / marks_per_beacon + 10) ticks, 2.01 s, got 2",
        ),
        (
            tables({"keep_range": 150.0}),
            "here: formation.keep_range must be below channel.communication_range, 150 m, got 150",
        ),
        (
            tables({}, event=[{"at": 5.0, "set": {"channel.communication_range": 120.0}}]),
            "here: formation.keep_range must be below channel.communication_range, 120 m, got 140",
        ),
        (
            tables({"plan_period": 9.0}, robots=201),
            "here: formation.configuration is for at most 200 robots, got 201",
        ),
        (
            tables({}, seeking={**MEASURED, "pooling": "none"}),
            "here: formation.configuration needs a dither that all links share: seeking.pooling must be 'network', "
            "got 'none'",
        ),
        (
            tables({"law": "voronoi"}),
            "here: formation: law: configuration 'lattice' replaces it and needs 'paper', got 'voronoi'",
        ),
        (
            tables({"configuration": "none", "law": "marks_and_plans"}),
            "here: formation: law: 'marks_and_plans' cannot be named, set formation.configuration to a shape",
        ),
        (
            tables({"rule": {"use": "tolerant_relative_neighborhood", "tolerance": 0.2}}),
            "here: formation: rule: 'tolerant_relative_neighborhood' has its settings in [formation] and takes no "
            "parameter, got 'tolerance'",
        ),
        (
            tables({"offsets": [[0.0, 0.0]]}),
            "here: formation: offsets: only configuration 'offsets' uses them, got 'lattice'",
        ),
        (
            tables({"configuration": "offsets", "offsets": [[0.0, 0.0], [1.0, 0.0]]}, robots=3),
            "here: formation.offsets must have a place for each of 3 robots, got 2",
        ),
        (
            tables({"configuration": "offsets", "offsets": [[0.0, 0.0], [2.0, 0.0]]}, robots=2),
            "here: formation.offsets: the nearest two of the first 2 must be 1 link length apart, got 2",
        ),
        (
            tables({"configuration": "offsets", "offsets": [[0.0, 0.0], [1.0, 0.0], [3.0, 0.0]]}, robots=3),
            "here: formation.offsets: the first 3 are not connected by links of up to 1.1 times the shortest",
        ),
        (
            {**tables({}), "robots": {"count": 10, "controller": "mylab:Robot"}},
            "here: robots.controller and formation.configuration exclude each other",
        ),
        (
            tables({"configuration": "hexagon"}),
            "here: formation.configuration: must be 'none', 'lattice', 'line', 'ring', 'ladder' or 'offsets', "
            "got 'hexagon'",
        ),
    ],
    ids=lambda value: "" if isinstance(value, dict) else value[6:60],
)
def test_a_broken_rule_is_rejected_in_one_line(settings: dict[str, Any], line: str) -> None:
    assert refusal(settings) == line


def test_the_least_plan_period_is_accepted() -> None:
    assert scenario.parse(tables({"plan_period": 0.9}), "here").formation.acting_law == "marks_and_plans"
    assert scenario.parse(tables({"configuration": "none"}), "here").formation.acting_law == "paper"


def test_a_dither_that_the_outermost_robot_cannot_follow_is_remarked() -> None:
    strong = {**MEASURED, "dither_amplitude": 8.0}
    quick = scenario.parse(tables({"linear_limit": 5.0, "rule": TOLERANT}, seeking=strong), "here")
    assert remarks.of(quick) == [
        "the dither moves the outermost of 10 robots at up to 3.77 m/s: above 0.6 x formation.linear_limit, 3 m/s, "
        "robots fall behind it"
    ]
    slow = scenario.parse(tables({"linear_limit": 5.0, "rule": TOLERANT}, seeking=MEASURED), "here")
    unlimited = scenario.parse(tables({"rule": TOLERANT}, seeking=strong), "here")
    assert [*remarks.of(slow), *remarks.of(unlimited)] == []


def test_a_rule_that_drops_the_links_of_a_lattice_is_remarked() -> None:
    assert remarks.of(scenario.parse(tables({}), "here")) == [
        "formation.rule 'relative_neighborhood' drops about half of the equal links of a lattice: "
        "'tolerant_relative_neighborhood' keeps them"
    ]
    for formation in ({"rule": TOLERANT}, {"configuration": "ring"}, {"configuration": "none"}):
        assert remarks.of(scenario.parse(tables(formation), "here")) == []


def test_a_plan_period_that_the_run_does_not_reach_is_remarked() -> None:
    late = scenario.parse({**tables({"rule": TOLERANT, "plan_period": 50.0}), "run": {"duration": 40.0}}, "here")
    assert remarks.of(late) == [
        "formation.plan_period 50 s: the first plan would come after the end of the run at 40 s, and the robots stay "
        "where they are"
    ]


def test_a_law_without_quality_weights_is_remarked() -> None:
    sampled = scenario.parse(tables({"rule": TOLERANT}, seeking={"index": "sampled"}), "here")
    assert remarks.of(sampled) == [
        "seeking.index 'sampled' seeks r*, and not the link length that is best for formation.configuration: "
        "'oracle' and 'measured' do"
    ]


def test_a_keep_range_below_the_best_link_length_is_remarked() -> None:
    for keep_range, lines in (
        (
            60.0,
            [
                "formation.keep_range, 60 m, is below the best link length of the configuration, 71.3 m: its links "
                "get no longer"
            ],
        ),
        (72.0, []),
    ):
        assert target.remarks(scenario.parse(tables({"keep_range": keep_range}), "here")) == lines
    assert target.remarks(scenario.parse(tables({"configuration": "none", "keep_range": 60.0}), "here")) == []


def test_fields_of_a_configuration_or_a_filter_without_one_are_remarked() -> None:
    useless = {"configuration": "none", "keep_range": 90.0, "plan_period": 3.0, "give_way_gain": 2.0}
    assert remarks.of(scenario.parse(tables(useless), "here")) == [
        "formation.plan_period, formation.keep_range have no effect: formation.configuration is 'none'",
        "formation.give_way_gain has no effect: formation.safe_separation is not set",
    ]
    assert remarks.of(scenario.parse(tables({"configuration": "none", "link_tolerance": 0.2}), "here")) == [
        "formation.link_tolerance has no effect: formation.rule is not 'tolerant_relative_neighborhood'"
    ]


def test_robots_that_start_closer_than_the_safe_separation_are_remarked() -> None:
    near = {"poses": [(0.0, 0.0, 0.0), (60.0, 0.0, 0.0), (61.0, 0.0, 0.0)]}
    settings = {"safe_separation": 5.0, "linear_limit": 5.0, "configuration": "none"}
    assert remarks.of(scenario.parse({**tables(settings), "robots": near}, "here")) == [
        "robots 1 and 2 start 1 m apart: formation.safe_separation, 5 m, holds only for robots that start further "
        "apart"
    ]
