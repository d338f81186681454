"""The command fes sweep challenge: all schemes from one start on the same radio draws, as table and figure."""

import csv
from pathlib import Path
from typing import Any

import pytest

from console.sweep import ledger
from fes.system import strict_json
from tests.support.commands import call, complaint
from world.config.builtin import file_of
from world.config.outside import schemes

SCHEMES = [scheme.name for scheme in schemes.of_file(file_of("challenge")).scheme]
TOLD = {"printed", "corrected, two nearest", "corrected", "lattice", "gradient"}


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("challenge")
    words = ["--seeds", "0:2", "--set", "run.duration=1", "--plot", "--out", "out"]
    done = call(folder, "fes", "sweep", "challenge", *words)
    assert done.returncode == 0, done.stderr
    lines = [line.split() for line in done.stdout.splitlines()]
    for name in SCHEMES[2:]:  # ten columns, three beside each other
        assert len([words for words in lines if words[:1] == [name]]) == 4, done.stdout
    return folder / "out"


def summary_of(folder: Path) -> dict[str, Any]:
    return strict_json.loads((folder / "summary.json").read_text())  # type: ignore[no-any-return]


def rows(path: Path) -> list[list[str]]:
    return [[entry.strip() for entry in line.strip("| \n").split("|")] for line in path.read_text().splitlines()]


def test_the_table_has_a_row_for_each_scheme_and_says_which_are_told_the_channel(out: Path) -> None:
    head, _, *body = rows(out / "schemes.md")
    assert head[:3] == ["scheme", "told the channel", "mean J over links"]
    assert [row[0] for row in body] == SCHEMES
    assert {row[0] for row in body if row[1] == "yes"} == TOLD
    assert all("±" in entry for row in body for entry in row[2:7])


def test_every_scheme_has_the_same_seeds_and_no_run_fails(out: Path) -> None:
    with (out / "table.csv").open() as file:
        table = list(csv.DictReader(file))
    assert [(row["scheme"], row["seed"]) for row in table] == [(name, seed) for name in SCHEMES for seed in "01"]
    assert {row["error"] for row in table} == {""}
    # until its first plan, after 2 s, a lattice stands still
    moving = [row["digest"] for row in table if not row["scheme"].startswith("lattice")]
    assert len(set(moving)) == len(moving) == 2 * (len(SCHEMES) - 2)


def test_the_figure_is_drawn(out: Path) -> None:
    assert (out / "sweep.png").read_bytes().startswith(b"\x89PNG")
    text = (out / "sweep.svg").read_text()
    assert "</svg>" in text


def test_the_ledger_has_the_schemes_as_an_axis_and_the_same_command_repeats_no_run(out: Path) -> None:
    before = (out / ledger.LINES).read_bytes()
    words = ["--seeds", "0:2", "--set", "run.duration=1", "--out", "out"]
    assert call(out.parent, "fes", "sweep", "challenge", *words).returncode == 0
    assert (out / ledger.LINES).read_bytes() == before
    assert '"scheme": [\n   "printed"' in (out / ledger.HEADER).read_text()


def test_a_scheme_alone_is_a_run_and_an_axis_chooses_among_them(out: Path) -> None:
    words = ["--axis", "scheme=voronoi,gradient", "--seeds", "0:1", "--set", "run.duration=1", "--out", "few"]
    done = call(out.parent, "fes", "sweep", "challenge", *words)
    assert [row[0] for row in rows(out.parent / "few" / "schemes.md")[2:]] == ["voronoi", "gradient"], done.stderr
    wrong = complaint(call(out.parent, "fes", "run", "challenge", "--set", "scheme=voronoy"), "fes")
    assert "there is no scheme 'voronoy'; did you mean 'voronoi'?" in wrong


@pytest.mark.parametrize(("scheme", "is_free"), [("gradient", False), ("alpha_lattice", True)])
def test_robots_in_processes_have_the_same_digits_and_say_whether_they_were_told_the_channel(
    scheme: str, is_free: bool, tmp_path: Path
) -> None:
    words = ["challenge", "--set", f"scheme={scheme}", "--duration", "0.4", "--headless", "--json"]
    alone = call(tmp_path, "fes", "run", *words, "--backend", "inprocess", "--out", "a")
    apart = call(tmp_path, "fes", "run", *words, "--backend", "processes", "--out", "b")
    first, second = (summary_of(tmp_path / folder) for folder in "ab")
    assert (alone.returncode, apart.returncode) == (0, 0), apart.stderr
    assert first["digest"] == second["digest"]
    assert (first["model_free"], second["model_free"]) == (None, is_free)
