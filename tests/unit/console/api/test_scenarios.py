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


def test_an_extension_with_its_parameters_is_one_value() -> None:
    law = {"use": "voronoi", "gain": 0.5}
    expected = scenario.load(CONFIGS / "pair.toml", {"formation.law": law, "seeking": {"use": "krstic_wang"}})
    overrides: dict[str, object]
    for overrides in (
        {"formation.law": law, "seeking": {"use": "krstic_wang"}},
        {"formation": {"law": {**law, "gain": np.float64(0.5)}}, "seeking": {"use": "krstic_wang"}},
    ):
        assert fes.load("pair", overrides) == expected
        former = fes.load("pair", {"formation.law": {"use": "alpha_lattice", "force_gain": 0.1}})
        assert fes.run(former, overrides={**overrides, "run.duration": 0.1}).scenario.formation == expected.formation


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


def test_a_scenario_object_takes_a_trace_as_a_name_does(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "links.csv").write_text("time,sender,receiver,probability\n0,0,1,1\n0,1,0,1\n")
    monkeypatch.chdir(tmp_path)
    measured = {"seeking.index": "measured", "run.duration": 0.2}
    trace = {"channel": {"model": "trace", "trace": "links.csv"}}
    by_name = fes.run("pair", overrides={**measured, **trace}, progress=False)
    by_object = fes.run(fes.load("pair", measured), overrides=trace, progress=False)
    assert by_object.scenario == by_name.scenario
    assert by_object.digest == by_name.digest
