"""The ledger of a sweep: whole lines, each run once, one design a directory."""

from pathlib import Path

import pytest

from console.sweep import design, ledger, work
from fes.errors import FesError
from tests.support.paths import PAIR


def test_a_line_that_a_kill_tore_off_is_dropped_and_written_anew(tmp_path: Path) -> None:
    planned = design.plan(Path(PAIR), [], "0:3", [])
    ended = [work.Done(run.key, {"ticks": run.seed}) for run in planned.runs]
    (tmp_path / f".{ledger.HEADER}").write_text("{")  # so does one that came while the first file was written
    with ledger.opened(tmp_path, planned) as book:
        book.add(ended)
        book.add(ended)
    whole = (tmp_path / ledger.LINES).read_bytes()
    assert whole.count(b"\n") == 3
    (tmp_path / ledger.LINES).write_bytes(whole[:-7])
    with ledger.opened(tmp_path, planned) as book:
        assert list(book.done.values()) == ended[:2]
        book.add(ended)
    assert (tmp_path / ledger.LINES).read_bytes() == whole


@pytest.mark.parametrize(
    ("axes", "settings", "said"),
    [
        (["formation.rule=disk"], [], "other axes"),
        ([], ["run.duration=3"], "another scenario"),
    ],
)
def test_a_directory_of_another_sweep_is_left_alone(
    axes: list[str], settings: list[str], said: str, tmp_path: Path
) -> None:
    with ledger.opened(tmp_path, design.plan(Path(PAIR), [], "0:2", [])):
        pass
    with ledger.opened(tmp_path, design.plan(Path(PAIR), [], "0:9", [])):
        pass  # more seeds are the same sweep
    other = design.plan(Path(PAIR), axes, "0:2", settings)
    with pytest.raises(FesError, match=f"holds a sweep of {said}"), ledger.opened(tmp_path, other):
        pass


def test_a_directory_in_use_and_one_that_is_no_sweeps_are_refused(tmp_path: Path) -> None:
    planned = design.plan(Path(PAIR), [], "0:2", [])
    with ledger.opened(tmp_path, planned):
        with pytest.raises(FesError, match="another fes sweep is at work"), ledger.opened(tmp_path, planned):
            pass
        with (tmp_path / ledger.LINES).open("ab") as file:
            file.write(b"gibberish\n")
    with pytest.raises(FesError, match="line 1 is not a run"), ledger.opened(tmp_path, planned):
        pass
    (tmp_path / ledger.HEADER).unlink()
    with pytest.raises(FesError, match="not empty, and no sweep's"), ledger.opened(tmp_path, planned):
        pass
