"""Built-in scenarios: names, files that come first, and errors that suggest a name."""

from pathlib import Path

import pytest

from fes.errors import ScenarioError
from tests.support.paths import CONFIGS
from world.config import builtin
from world.config.scenario import load


def test_the_names_are_those_of_the_files_in_configs() -> None:
    files = {str(path.relative_to(CONFIGS)).removesuffix(".toml") for path in CONFIGS.rglob("*.toml")}
    assert len(builtin.names()) == len(files)
    assert set(builtin.names()) == files


@pytest.mark.parametrize("name", builtin.names())
def test_each_name_is_a_valid_scenario(name: str) -> None:
    assert builtin.resolve(Path(name)) == CONFIGS / f"{name}.toml"
    load(builtin.file_of(name))


def test_an_existing_file_comes_before_a_built_in_scenario_and_a_folder_does_not(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("pair").mkdir()
    assert builtin.resolve(Path("pair")) == CONFIGS / "pair.toml"
    Path("paper").touch()
    assert builtin.resolve(Path("paper")) == Path("paper")
    Path("faults").mkdir()
    assert builtin.resolve(Path("faults/death")) == CONFIGS / "faults" / "death.toml"
    assert builtin.resolve(Path("faults")) == Path("faults")


@pytest.mark.parametrize(
    ("scenario", "near"),
    [
        ("papr", "paper"),
        ("death", "faults/death"),
        ("faults/deaht", "faults/death"),
        ("configs/paper.toml", "paper"),
        ("measured_jump.toml", "measured-jump"),
    ],
)
def test_an_error_names_the_nearest_built_in_scenario(
    scenario: str, near: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ScenarioError) as caught:
        builtin.resolve(Path(scenario))
    assert str(caught.value) == (
        f"{scenario}: No such file, and not the name of a built-in scenario: "
        f"the nearest is '{near}', and fes run --help lists all of them"
    )


@pytest.mark.parametrize("scenario", ["qqqqqq", "../paper", "nowhere/..", "x" * 300])
def test_a_scenario_that_does_not_exist_is_an_error(
    scenario: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises((ScenarioError, OSError)):
        load(builtin.resolve(Path(scenario)))


def test_a_shell_completes_names() -> None:
    assert builtin.completions("measured-") == ["measured-coverage", "measured-jump"]


def test_a_path_that_the_system_cannot_examine_is_reported_where_it_is_opened() -> None:
    with pytest.raises(ScenarioError, match=r"cannot be read: File name too long$"):
        load(builtin.resolve(Path("a" * 5000)))
