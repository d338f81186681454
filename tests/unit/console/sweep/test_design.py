"""The arguments of fes sweep become cells, seeds and runs, or an error of one line."""

from pathlib import Path

import pytest

from console.sweep import design
from fes.errors import ScenarioError
from fes.model.table import chosen
from tests.support.paths import CONFIGS

PAIR = CONFIGS / "pair.toml"


def test_axes_are_crossed_in_their_order_and_every_cell_has_every_seed() -> None:
    planned = design.plan(
        PAIR, ["formation.rule=disk,two_nearest", "formation.linear_gain=1,2.5"], "3,1", ["run.duration=2"]
    )
    assert planned.axes == ("formation.rule", "formation.linear_gain")
    assert [cell.values for cell in planned.cells] == [
        ("disk", 1.0),
        ("disk", 2.5),
        ("two_nearest", 1.0),
        ("two_nearest", 2.5),
    ]
    assert [(run.cell, run.seed) for run in planned.runs] == [(cell, seed) for cell in range(4) for seed in (3, 1)]
    last = planned.runs[-1].scenario
    assert (last.formation.rule, last.formation.linear_gain, last.run.seed) == ("two_nearest", 2.5, 1)
    assert {run.scenario.run.duration for run in planned.runs} == {2.0}


def test_a_list_is_one_value_of_an_axis() -> None:
    planned = design.plan(PAIR, ["seeking.initial_estimate=[50.0, 90],[60,60]"], "0:1", [])
    assert [cell.values for cell in planned.cells] == [("[50.0, 90.0]",), ("[60.0, 60.0]",)]


def test_an_extension_with_its_parameters_is_one_value_of_an_axis() -> None:
    axis = 'formation.law={use="voronoi", gain=0.5},{use="voronoi", gain=1.0},paper'
    planned = design.plan(PAIR, [axis], "0:1", [])
    assert [cell.values for cell in planned.cells] == [
        ("voronoi(gain=0.5)",),
        ("voronoi(gain=1.0)",),
        ("paper",),
    ]


def test_the_name_of_the_law_of_the_file_keeps_its_parameters_on_an_axis(tmp_path: Path) -> None:
    path = tmp_path / "tuned.toml"
    path.write_text(PAIR.read_text().replace("[formation]", '[formation]\nlaw = {use = "voronoi", gain = 0.5}'))
    planned = design.plan(path, ["formation.law=voronoi,paper"], "0:1", [])
    assert [cell.values for cell in planned.cells] == [("voronoi",), ("paper",)]
    assert [chosen(run.scenario.formation.law).parameters for run in planned.runs] == [{"gain": 0.5}, {}]


def test_the_names_and_the_parameters_of_extensions_are_axes() -> None:
    named = design.plan(PAIR, ["formation.law.use=voronoi,paper", "seeking.use=krstic_wang"], "0:1", [])
    assert [cell.values for cell in named.cells] == [("voronoi", "krstic_wang"), ("paper", "krstic_wang")]
    tuned = design.plan(PAIR, ["formation.law.gain=0.5,1.0"], "0:1", ["formation.law=voronoi"])
    assert [cell.values for cell in tuned.cells] == [(0.5,), (1.0,)]


def test_the_key_of_a_run_depends_on_everything_that_it_does_and_on_nothing_else(tmp_path: Path) -> None:
    def key(*settings: str, path: Path = PAIR, seeds: str = "1") -> str:
        return design.plan(path, [], seeds, list(settings)).runs[0].key

    copy = tmp_path / "copy.toml"
    copy.write_text("# the same, under another name\n" + PAIR.read_text())
    assert key() == key(path=copy)
    assert key() == key("formation.contact_timeout=1.0")  # the default, given explicitly
    others = [key("run.duration=1"), key("channel.reference_snr=1e8"), key(seeds="2")]
    assert len({key(), *others}) == 4


@pytest.mark.parametrize(
    ("axes", "seeds", "settings", "message_parts"),
    [
        (["formation.rul=disk"], "0:2", [], ["'formation.rul'", "'formation.rule'"]),
        (["formation.rule=disk,ring"], "0:2", [], ["formation.rule", "'ring'"]),
        (["formation.rule"], "0:2", [], ["--axis", "table.field=value,value", "'formation.rule'"]),
        (["formation.rule="], "0:2", [], ["--axis", "'formation.rule='"]),
        (["formation.rule=disk,"], "0:2", [], ["--axis", "'formation.rule=disk,'"]),
        (["formation.rule=disk,disk"], "0:2", [], ["--axis", "each value", "disk, disk"]),
        (["formation.linear_gain=1,1.0"], "0:2", [], ["--axis", "each value", "'formation.linear_gain'"]),
        (["run.dt=0.02", "run.dt=0.01"], "0:2", [], ["--axis", "each field once", "'run.dt'"]),
        (["run.dt=0.02"], "0:2", ["run.dt=0.01"], ["--set", "'run.dt'"]),
        (["run.seed=1,2"], "0:2", [], ["--seeds", "'run.seed'"]),
        ([], "0:2", ["run.seed=1"], ["--seeds", "'run.seed'"]),
        (["channel={model='perfect'}"], "0:2", [], ["--axis", "'channel' is a table"]),
        ([], "0:0", [], ["--seeds", "A < B", "'0:0'"]),
        ([], "5:2", [], ["--seeds", "'5:2'"]),
        ([], "-1:2", [], ["--seeds", "'-1:2'"]),
        ([], "a:b", [], ["--seeds", "'a:b'"]),
        ([], "", [], ["--seeds", "''"]),
        ([], "1,1", [], ["--seeds", "each seed once", "'1,1'"]),
        ([], "0:99999999999", [], ["--seeds", "at most 1000000"]),
        (["formation.linear_gain=1,2"], "0:600000", [], ["at most 1000000", "1200000"]),
    ],
)
def test_a_design_that_breaks_a_rule_is_rejected_in_one_line(
    axes: list[str], seeds: str, settings: list[str], message_parts: list[str]
) -> None:
    with pytest.raises(ScenarioError) as refused:
        design.plan(PAIR, axes, seeds, settings)
    line = str(refused.value)
    assert [word for word in message_parts if word not in line] == []
    assert "\n" not in line
