"""The rules of a configuration and of its neighbor rule: each broken one is rejected in one line."""

from typing import Any

import pytest

from fes.errors import ScenarioError
from fes.model.config import TOLERANT
from world.config import remarks, scenario

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
            "here: formation: law: configuration 'lattice' has its own, got 'voronoi'",
        ),
        (
            tables({"configuration": "none", "law": "marks_and_plans"}),
            "here: formation: law: 'marks_and_plans' is chosen by its shape, formation.configuration",
        ),
        (
            tables({"rule": {"use": "tolerant_relative_neighborhood", "tolerance": 0.2}}),
            "here: formation: rule: 'tolerant_relative_neighborhood' takes its settings from [formation] itself, "
            "got 'tolerance'",
        ),
        (
            tables({"offsets": [[0.0, 0.0]]}),
            "here: formation: offsets: only configuration 'offsets' uses them, got 'lattice'",
        ),
        (
            tables({"configuration": "offsets", "offsets": [[0.0, 0.0], [1.0, 0.0]]}, robots=3),
            "here: formation.offsets: 3 robots need as many, got 2",
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
            "here: robots.controller replaces the law that would take up formation.configuration",
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
