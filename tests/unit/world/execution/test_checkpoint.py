"""Notes and checkpoints of a run: torn, damaged, or crafted to do harm."""

import argparse
import hashlib
import os
import pickle
from pathlib import Path
from typing import Any

import pytest

from fes.errors import FesError
from fes.protocol.messages import Join
from tests.support.loop import load
from tests.support.teams import begun
from world import process
from world.execution import checkpoint, journal, resume
from world.execution.checkpoint import CheckpointWriter
from world.execution.run import Run
from world.process import main


def test_the_last_journal_entry_may_be_torn(tmp_path: Path) -> None:
    path = tmp_path / "journal"
    kept = journal.Journal(path)
    notes: list[list[Any]] = [["attend", 3, [0, 1]], ["tick", 3, [b"\x00\xff", b""], []]]
    ends = []
    for note in notes:
        kept.add(note)
        ends.append(path.stat().st_size)
    kept.close()
    content = path.read_bytes()
    for length in range(len(content) + 1):
        path.write_bytes(content[:length])
        assert list(journal.notes(path)) == notes[: sum(end <= length for end in ends)]


def test_a_flipped_bit_anywhere_in_a_journal_is_damage_and_so_are_zeros_at_its_end(tmp_path: Path) -> None:
    # If a last note with a wrong checksum were dropped, a confirmed change by a person would be lost silently.
    path = tmp_path / "journal"
    kept = journal.Journal(path)
    for number in range(3):
        kept.add(["set", number, "channel.reference_snr", 1.1 + number])
    kept.close()
    content = path.read_bytes()
    for place in range(len(content)):
        for bit in range(8):
            path.write_bytes(content[:place] + bytes([content[place] ^ 1 << bit]) + content[place + 1 :])
            with pytest.raises(FesError, match=r"journal is damaged at byte \d+: "):
                list(journal.notes(path))
    for count in range(1, 100):  # the system writes from front to end, so zeros at the end are damage
        path.write_bytes(content[:-count] + bytes(count))
        with pytest.raises(FesError, match=r"journal is damaged at byte \d+: "):
            list(journal.notes(path))


def test_journal_entries_that_are_lost_moved_or_of_another_run_are_damage(tmp_path: Path) -> None:
    first, second = tmp_path / "journal-1", tmp_path / "journal-2"
    ends, checksum = list[int](), 7
    for number, path in enumerate((first, second), 1):
        kept = journal.Journal(path, number, checksum)
        for tick in range(3):
            ends.append(path.stat().st_size)
            kept.add(["set", tick, "a", 1.0])
        checksum = kept.checksum
        kept.close()

    def read(paths: list[Path], number: int = 1, checksum: int = 7) -> list[list[Any]]:
        return [note for _, note in journal.chained(paths, number, checksum)]

    assert len(read([first, second])) == 6
    content = first.read_bytes()
    size = ends[1] - ends[0]
    lost = content[: ends[0]] + content[ends[1] :]
    moved = content[: ends[0]] + content[ends[1] :] + content[ends[0] : ends[1]]
    twice = content[: ends[1]] + content[ends[0] :]
    for changed in (lost, moved, twice, content[:-size], content[:-1], content[:5], b""):
        first.write_bytes(changed)
        with pytest.raises(FesError, match=r"journal-[12] is damaged"):
            read([first, second])
    first.write_bytes(content)
    for paths, number, first_tick in (([second], 1, 7), ([first], 2, 7), ([first, second], 1, 8), ([], 1, 7)):
        with pytest.raises(FesError, match=r"is damaged: notes before it are missing|^journal 1 is missing"):
            read(paths, number, first_tick)
    # A resumed world dropped the cut note, and died again before its next checkpoint: the checksums prove it.
    first.write_bytes(content + b"x")
    assert len(read([first, second])) == 6


class Full:
    """A file on a full disk, which takes only the first bytes of a write until it has room again."""

    def __init__(self, file: Any) -> None:
        self._file, self.room = file, False

    def write(self, what: bytes) -> int:
        return int(self._file.write(what if self.room else what[:5]))

    def close(self) -> None:
        self._file.close()


def test_no_journal_entry_follows_one_that_did_not_fit_on_the_disk(tmp_path: Path) -> None:
    kept = journal.Journal(tmp_path / "journal")
    kept.add(["set", 1, "first", 1.0])
    full = kept._file = Full(kept._file)  # type: ignore[assignment]
    for room in (False, True):
        full.room = room
        with pytest.raises(FesError, match=r"there is no room$"):
            kept.add(["set", 2, "second", 2.0])
    kept.close()
    assert list(journal.notes(kept.path)) == [["set", 1, "first", 1.0]]


def test_the_last_join_determines_the_robots_of_a_process(tmp_path: Path) -> None:
    checkpoints = CheckpointWriter(tmp_path, 1e9, "test", "main")
    run = Run(load("neighborhood.toml"), note=checkpoints.note)
    checkpoints.begin(run)
    for robots in ([0, 1, 2], [0], [1, 2], [0, 1, 2], [2]):
        checkpoints.note(["join", robots, sum(robots)])
    checkpoints.close(run)
    again, kept, _ = resume.run(tmp_path, resume.load(tmp_path), None, 1e9)
    assert kept.hosts == {0: Join((0, 1, 2), 3), 1: Join((0, 1, 2), 3), 2: Join((2,), 2)}
    assert kept.renewed == {0, 1, 2}
    kept.note(["tick", 0, [b"", b"x", b"x"], [], b"", 0.0])
    assert kept.renewed == {0}
    kept.discard(again)


def holding(state: bytes, pickled: bytes) -> bytes:
    """The file of a state with another pickle in it, and the right checksum."""
    magic, _, head, _ = state.split(b"\n", 3)
    checksum = hashlib.sha256(head + b"\n" + pickled).hexdigest().encode()
    return b"\n".join([magic, checksum, head, pickled])


class Trap:
    """Runs a command when it is unpickled."""

    def __reduce__(self) -> Any:
        return os.mkdir, ("trapped",)


HARM = {
    "a call": pickle.dumps(Trap()),
    "an import": b"ctrap\nanything\n.",
    "a function of the world": b"cworld.execution.checkpoint\nclear\n(Vtrapped\ntR.",
    "what the world imports": b"cworld.execution.checkpoint\nshutil\n.",
    "a class that others made": b"cworld.execution.checkpoint\nPath\n(Vtrapped\ntR.",
    "a class of the world that is not a table": b"cworld.execution.checkpoint\nCheckpointWriter\n.",
}


@pytest.mark.parametrize("told", HARM.values(), ids=HARM)
def test_loading_a_checkpoint_cannot_execute_code(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, told: bytes
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    Path("trap.py").write_text('import os\nos.mkdir("trapped")\n')
    state = begun(tmp_path / "run")
    state.write_bytes(holding(state.read_bytes(), told))
    with pytest.raises(FesError, match=r"is damaged: UnpicklingError$"):
        resume.load(tmp_path / "run")
    assert not Path("trapped").exists()


def test_an_unusable_checkpoint_is_rejected_in_one_line(tmp_path: Path) -> None:
    with pytest.raises(FesError, match=r"has no checkpoint: its run is over, or wrote none$"):
        resume.load(tmp_path)
    state = begun(tmp_path / "run")
    content = state.read_bytes()
    for damaged, complaint in [
        (b"", "is not a checkpoint$"),
        (b"fes checkpoint 9\n1\n", "is a checkpoint of format 9; this fes reads format 7$"),
        (content[:-10], "is damaged: its SHA-256 differs$"),
        (content[:300] + b"\0" + content[301:], "is damaged: its SHA-256 differs$"),
        (content.replace(b'"numpy": "', b'"numpy": "9'), "is damaged: its SHA-256 differs$"),
        (holding(content, pickle.dumps(3)), "is not a checkpoint$"),
    ]:
        state.write_bytes(damaged)
        with pytest.raises(FesError, match=complaint):
            resume.load(tmp_path / "run")
    state.write_bytes(content)
    snapshot = resume.load(tmp_path / "run")
    [path] = checkpoint.journals(tmp_path / "run", 0)
    notes: list[list[Any]] = [
        ["tick", 7, [], []],
        ["tick"],
        [[]],
        ["set", 0, {}, 1],
        ["join", 3, 1],
        ["tick", 0, 1, 1, 1, 1],
    ]
    for note in notes:
        path.unlink()
        kept = journal.Journal(path, snapshot.number, snapshot.checksum)
        kept.add(note)
        kept.close()
        with pytest.raises(FesError, match=r"^the notes in .*checkpoint are damaged: ") as caught:
            resume.run(tmp_path / "run", resume.load(tmp_path / "run"), None, 1e9)
        assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        ([], "give a SCENARIO, or --resume RUN_DIR"),
        (["--resume", "nowhere"], "there is no run directory nowhere"),
        (["x.toml", "--resume", "nowhere"], "--resume keeps the settings of the run"),
        (["--resume", "nowhere", "--seed", "3"], "--resume keeps the settings of the run"),
    ],
)
def test_flags_that_exclude_each_other_are_reported_in_one_line(
    words: list[str], complaint: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.argv", ["fes-world", *words])
    with pytest.raises(SystemExit):
        main()
    assert complaint in capsys.readouterr().err


def test_a_new_run_removes_the_checkpoint_of_an_older_one(tmp_path: Path) -> None:
    begun(tmp_path / "run")
    flags = argparse.Namespace(out=tmp_path / "run", no_record=True, checkpoint=0.0)
    process._open_log(flags, process.Start(load("pair.toml"), "pair", "main"))
    assert not checkpoint.has_checkpoint(tmp_path / "run")
