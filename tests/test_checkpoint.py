"""What a run is gone on from: notes and checkpoints that may be torn, damaged, or made to do harm."""

import argparse
import os
import pickle
from pathlib import Path
from typing import Any

import pytest

from fes.errors import FesError
from fes.messages import Join
from tests.loop import load
from world import checkpoint, journal, process, resume
from world.checkpoint import FOLDER, Keeper
from world.course import Course
from world.process import main


def test_the_last_note_may_be_torn(tmp_path: Path) -> None:
    path = tmp_path / "journal"
    kept = journal.Journal(path)
    notes: list[list[Any]] = [["attend", 3, [0, 1]], ["tick", 3, [b"\x00\xff", b""], []]]
    ends = []
    for note in notes:
        kept.add(note)
        ends.append(path.stat().st_size)
    kept.close()
    whole = path.read_bytes()
    for length in range(len(whole) + 1):
        path.write_bytes(whole[:length])
        assert list(journal.notes(path)) == notes[: sum(end <= length for end in ends)]
    path.write_bytes(whole[:-1] + b"x")
    assert list(journal.notes(path)) == notes[:1]


class Full:
    """A file on a disk without room for more than the head of what is written, until there is again."""

    def __init__(self, file: Any) -> None:
        self._file, self.room = file, False

    def write(self, what: bytes) -> int:
        return int(self._file.write(what if self.room else what[:5]))

    def close(self) -> None:
        self._file.close()


def test_after_a_note_for_which_there_was_no_room_there_are_no_others(tmp_path: Path) -> None:
    kept = journal.Journal(tmp_path / "journal")
    kept.add(["set", 1, "first", 1.0])
    full = kept._file = Full(kept._file)  # type: ignore[assignment]
    for room in (False, True):
        full.room = room
        with pytest.raises(FesError, match=r"there is no room$"):
            kept.add(["set", 2, "second", 2.0])
    kept.close()
    assert list(journal.notes(kept.path)) == [["set", 1, "first", 1.0]]


def test_who_shares_a_process_is_what_was_last_joined(tmp_path: Path) -> None:
    course, keeper = Course(load("neighborhood.toml")), Keeper(tmp_path, 1e9, "test", "main")
    keeper.begin(course)
    for robots in ([0, 1, 2], [0], [1, 2], [0, 1, 2], [2]):
        keeper.note(["join", robots, sum(robots)])
    keeper.close(course)
    again, kept, _ = resume.course(tmp_path, resume.load(tmp_path), None, 1e9)
    assert kept.hosts == {0: Join((0, 1, 2), 3), 1: Join((0, 1, 2), 3), 2: Join((2,), 2)}
    assert kept.renewed == {0, 1, 2}
    kept.note(["tick", 0, [b"", b"x", b"x"], [], b"", 0.0])
    assert kept.renewed == {0}
    kept.discard(again)


def begun(where: Path) -> Path:
    """A run directory with a checkpoint."""
    where.mkdir()
    course = Course(load("pair.toml"))
    keeper = Keeper(where, 1e9, "pair", "main")
    keeper.begin(course)
    keeper.close(course)
    return where / FOLDER / "state"


class Trap:
    """Runs a command when it is unpickled."""

    def __reduce__(self) -> Any:
        return os.mkdir, ("trapped",)


HARM = {
    "a call": pickle.dumps(Trap()),
    "an import": b"ctrap\nanything\n.",
    "a function of the world": b"cworld.checkpoint\nclear\n(Vtrapped\ntR.",
    "what the world imports": b"cworld.checkpoint\nshutil\n.",
    "a class that others made": b"cworld.checkpoint\nPath\n(Vtrapped\ntR.",
    "a class of the world that is no table": b"cworld.checkpoint\nKeeper\n.",
}


@pytest.mark.parametrize("told", HARM.values(), ids=HARM)
def test_a_checkpoint_cannot_run_anything(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, told: bytes) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    Path("trap.py").write_text('import os\nos.mkdir("trapped")\n')
    state = begun(tmp_path / "run")
    magic, version, _ = state.read_bytes().split(b"\n", 2)
    state.write_bytes(b"\n".join([magic, version, told]))
    with pytest.raises(FesError, match=r"is damaged: UnpicklingError$"):
        resume.load(tmp_path / "run")
    assert not Path("trapped").exists()


def test_what_cannot_be_gone_on_from_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(FesError, match=r"has no checkpoint: its run is over, or kept none$"):
        resume.load(tmp_path)
    state = begun(tmp_path / "run")
    whole = state.read_bytes()
    magic, _, told = whole.split(b"\n", 2)
    for damaged, complaint in [
        (b"", "is not a checkpoint$"),
        (b"fes checkpoint 9\n1\n", "is not a checkpoint that this fes can read$"),
        (magic + b"\n9.9\n" + told, "was kept by fes 9.9, this is "),
        (whole[:-10], "is damaged: "),
        (magic + b"\n" + whole.split(b"\n")[1] + b"\n" + pickle.dumps(3), "is not a checkpoint$"),
    ]:
        state.write_bytes(damaged)
        with pytest.raises(FesError, match=complaint):
            resume.load(tmp_path / "run")
    state.write_bytes(whole)
    snapshot = resume.load(tmp_path / "run")
    notes = journal.Journal(checkpoint.journals(tmp_path / "run", 0)[-1])
    notes.add(["tick", 7, [], []])
    notes.close()
    with pytest.raises(FesError, match=r"are damaged: a note of tick 7 stands at tick 0$"):
        resume.course(tmp_path / "run", snapshot, None, 1e9)


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        ([], "give a SCENARIO, or --resume RUN_DIR"),
        (["--resume", "nowhere"], "there is no run directory nowhere"),
        (["x.toml", "--resume", "nowhere"], "--resume goes on with the run as it was"),
        (["--resume", "nowhere", "--seed", "3"], "--resume goes on with the run as it was"),
    ],
)
def test_flags_that_do_not_go_together_are_one_line(
    words: list[str], complaint: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.argv", ["fes-world", *words])
    with pytest.raises(SystemExit):
        main()
    assert complaint in capsys.readouterr().err


def test_a_new_run_leaves_nothing_of_an_older_one_to_go_on_from(tmp_path: Path) -> None:
    begun(tmp_path / "run")
    flags = argparse.Namespace(out=tmp_path / "run", no_record=True, checkpoint=0.0)
    process._recorder(flags, process.Start(load("pair.toml"), "pair", "main"))
    assert not checkpoint.is_kept(tmp_path / "run")
