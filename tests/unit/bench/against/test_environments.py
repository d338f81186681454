"""The environments of other programs: kept while their requirements are the same, and reasons when they fail."""

from collections.abc import Sequence
from pathlib import Path

import pytest

from bench.against import environments, programs
from bench.against.programs import NotMeasured


class Installer:
    """Records what would be installed, or fails."""

    def __init__(self, reason: str = "") -> None:
        self.reason = reason
        self.installed: list[list[str]] = []

    def __call__(self, place: Path, requirements: list[str]) -> None:
        place.mkdir(parents=True, exist_ok=True)
        if self.reason:
            raise NotMeasured(self.reason)
        self.installed.append(requirements)


def test_an_environment_is_made_once(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    installer = Installer()
    monkeypatch.setattr(environments, "_install", installer)
    first, second = environments.vmas(tmp_path), environments.vmas(tmp_path)
    assert first == second == tmp_path / "vmas-1.5.2" / "venv" / "bin" / "python"
    assert installer.installed == [["vmas==1.5.2"]]


def test_an_environment_that_failed_or_has_other_requirements_is_made_again(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(environments, "_install", Installer("no network"))
    with pytest.raises(NotMeasured, match="no network"):
        environments.vmas(tmp_path)
    installer = Installer()
    monkeypatch.setattr(environments, "_install", installer)
    environments.vmas(tmp_path)
    monkeypatch.setattr(environments, "VMAS", "vmas==1.5.2")
    (tmp_path / "vmas-1.5.2" / "ready.json").write_text('["3.11", "vmas==1.5.1"]')
    environments.vmas(tmp_path)
    assert len(installer.installed) == 2


def test_the_earlier_commit_gets_the_packages_of_this_process(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    installer, exported = Installer(), []

    def export(commit: str, place: Path) -> None:
        exported.append((commit, place))

    monkeypatch.setattr(environments, "_install", installer)
    monkeypatch.setattr(environments, "_export", export)
    environments.old(tmp_path)
    assert exported == [("85d335e", tmp_path / "85d335e" / "tree")]
    ((tree, numpy, zenoh),) = installer.installed
    assert tree == str(environments.tree(tmp_path))
    assert numpy.startswith("numpy==")
    assert zenoh.startswith("eclipse-zenoh==")


def test_the_cache_is_in_the_folder_of_the_user(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert environments.default_folder() == tmp_path / "fes-bench"
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setenv("HOME", str(tmp_path))
    assert environments.default_folder() == tmp_path / ".cache" / "fes-bench"


def test_a_program_gets_one_thread_and_loses_the_variables_that_are_none(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTHONPATH", "elsewhere")
    merged = programs.environment({**environments.ISOLATED, "FES_CORE": "numpy"})
    assert merged["OMP_NUM_THREADS"] == "1"
    assert merged["FES_CORE"] == "numpy"
    assert "PYTHONPATH" not in merged


@pytest.mark.parametrize("printed", ["", "warning: none"])
def test_a_program_that_prints_no_number_is_not_measured(monkeypatch: pytest.MonkeyPatch, printed: str) -> None:
    def output(words: Sequence[str | Path], variables: object, folder: Path | None = None) -> str:
        return printed

    monkeypatch.setattr(programs, "output", output)
    with pytest.raises(NotMeasured, match="printed no number"):
        programs.number(["program"], {})
