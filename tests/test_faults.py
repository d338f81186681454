"""Each scenario of configs/faults is as it expects to be."""

from pathlib import Path

import pytest

from console import inprocess
from tests.loop import CONFIGS
from world.scenario import load

FAULTS = sorted((CONFIGS / "faults").glob("*.toml"))


@pytest.mark.parametrize("path", FAULTS, ids=lambda path: path.stem)
def test_a_fault_is_survived_as_its_scenario_says(path: Path) -> None:
    scenario = load(path)
    assert scenario.expect
    verdicts = inprocess.run(scenario, path.stem)["expectations"]
    assert all(verdict["holds"] for verdict in verdicts), verdicts


@pytest.mark.parametrize("path", FAULTS, ids=lambda path: path.stem)
def test_a_fault_is_told_apart_from_a_run_without_it(path: Path) -> None:
    scenario = load(path)
    calm = scenario.model_copy(update={"event": []})
    assert inprocess.run(calm, "calm")["links_gap_longest"] == 0.0
    assert inprocess.run(scenario, "fault")["links_gap_longest"] > 0.5
