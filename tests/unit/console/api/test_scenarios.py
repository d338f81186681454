"""fes.load: overrides by dotted path, in nested tables, and with the numbers of numpy."""

from pathlib import Path

import numpy as np
import pytest

import fes
from fes.errors import ScenarioError
from tests.support.paths import CONFIGS
from world.config import scenario


@pytest.mark.parametrize(
    "overrides",
    [
        {"run.seed": 4, "run.dt": 0.01, "seeking.initial_estimate": [50.0, 60.0]},
        {"run": {"seed": np.int64(4), "dt": np.float64(0.01)}, "seeking.initial_estimate": np.array([50.0, 60.0])},
        {"run": {"seed": 4}, "run.dt": 0.01, "seeking": {"initial_estimate": (50.0, 60.0)}},
    ],
)
def test_all_forms_of_overrides_are_the_same_scenario(overrides: dict[str, object]) -> None:
    path = CONFIGS / "pair.toml"
    values = {"run.seed": 4, "run.dt": 0.01, "seeking.initial_estimate": [50.0, 60.0]}
    expected = scenario.load(path, values)
    for source in ("pair", path, str(path)):
        assert fes.load(source, overrides) == expected


def test_tables_in_lists_are_overrides_too() -> None:
    event = [{"at": np.float64(0.5), "set": {"channel.path_loss_exponent": 2.5}}]
    assert fes.load("pair", {"event": event}).changes == {25: {"channel.path_loss_exponent": 2.5}}


def test_a_file_that_is_not_a_scenario_is_an_error_of_one_line(tmp_path: Path) -> None:
    (tmp_path / "x.toml").write_text("schema = 1\n[channel]\nmodel = 'tin cans'\n")
    with pytest.raises(ScenarioError, match=r"x\.toml: "):
        fes.load(tmp_path / "x.toml")
    nested: dict[str, object] = {}
    deep = nested
    for _ in range(200):
        deep["x"] = deep = {}
    deep["x"] = 1
    with pytest.raises(ScenarioError, match=r"overrides: '.*' is nested too deeply"):
        fes.load("pair", nested)
