"""Each scenario of configs/faults meets its expectations with its golden digest, and does not without its fault."""

from pathlib import Path

import pytest

from console.backends import inprocess
from tests.support import golden
from tests.support.paths import CONFIGS
from world.config.scenario import load

FAULTS = sorted((CONFIGS / "faults").glob("*.toml"))


@pytest.mark.parametrize("path", FAULTS, ids=lambda path: path.stem)
def test_a_run_with_a_fault_meets_the_expectations_of_its_scenario(path: Path) -> None:
    scenario = load(path)
    assert scenario.expect
    summary = inprocess.run(scenario, path.stem)
    verdicts = summary["expectations"]
    assert all(verdict["holds"] for verdict in verdicts), verdicts
    assert summary["digest"] == golden.stored()[f"faults/{path.stem}"]


@pytest.mark.parametrize("path", [path for path in FAULTS if path.stem != "world"], ids=lambda path: path.stem)
def test_a_run_without_the_fault_does_not_meet_the_expectations(path: Path) -> None:
    scenario = load(path)
    calm = scenario.model_copy(update={"event": []})
    verdicts = inprocess.run(calm, "calm")["expectations"]
    assert not all(verdict["holds"] for verdict in verdicts), verdicts


def test_the_death_of_the_world_moves_no_robot() -> None:
    scenario = load(CONFIGS / "faults" / "world.toml", {"run.duration": 4.0})
    died, calm = (
        inprocess.run(variant, "world") for variant in (scenario, scenario.model_copy(update={"event": []}))
    )
    assert died["digest"] == calm["digest"]


def test_each_fault_has_a_scenario() -> None:
    named = {"death", "hang", "partition", "jam", "loss", "delay", "corrupt", "skew", "world"}
    assert named <= {path.stem for path in FAULTS}
