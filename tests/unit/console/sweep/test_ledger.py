"""The ledger of a sweep: complete lines, each run once, one design per directory."""

from pathlib import Path

import pytest

from console.sweep import design, ledger, work
from fes.errors import FesError
from tests.support.paths import PAIR


def test_a_line_cut_short_by_a_kill_is_dropped_and_rewritten(tmp_path: Path) -> None:
    planned = design.plan(Path(PAIR), [], "0:3", [])
    ended = [work.Done(run.key, {"ticks": run.seed}) for run in planned.runs]
    (tmp_path / f".{ledger.HEADER}").write_text("{")  # of a kill during the first write
    with ledger.opened(tmp_path, planned) as book:
        book.add(ended)
        book.add(ended)
    complete = (tmp_path / ledger.LINES).read_bytes()
    assert complete.count(b"\n") == 3
    (tmp_path / ledger.LINES).write_bytes(complete[:-7])
    with ledger.opened(tmp_path, planned) as book:
        assert list(book.done.values()) == ended[:2]
        book.add(ended)
    assert (tmp_path / ledger.LINES).read_bytes() == complete


@pytest.mark.parametrize(
    ("axes", "settings", "message"),
    [
        (["formation.rule=disk"], [], "other axes"),
        ([], ["run.duration=3"], "another scenario"),
    ],
)
def test_a_directory_of_another_sweep_is_not_changed(
    axes: list[str], settings: list[str], message: str, tmp_path: Path
) -> None:
    with ledger.opened(tmp_path, design.plan(Path(PAIR), [], "0:2", [])):
        pass
    with ledger.opened(tmp_path, design.plan(Path(PAIR), [], "0:9", [])):
        pass  # more seeds are the same sweep
    other = design.plan(Path(PAIR), axes, "0:2", settings)
    with pytest.raises(FesError, match=f"holds a sweep of {message}"), ledger.opened(tmp_path, other):
        pass


def test_a_directory_in_use_and_one_without_a_sweep_are_rejected(tmp_path: Path) -> None:
    planned = design.plan(Path(PAIR), [], "0:2", [])
    with ledger.opened(tmp_path, planned):
        with pytest.raises(FesError, match="another fes sweep is using it"), ledger.opened(tmp_path, planned):
            pass
        with (tmp_path / ledger.LINES).open("ab") as file:
            file.write(b"gibberish\n")
    with pytest.raises(FesError, match="line 1 is not a run"), ledger.opened(tmp_path, planned):
        pass
    (tmp_path / ledger.HEADER).unlink()
    with pytest.raises(FesError, match="not empty, and holds no sweep"), ledger.opened(tmp_path, planned):
        pass
