"""An incomplete checkpoint: the run resumes from the one before it, and from all notes since."""

import contextlib
import os
import resource
from collections.abc import Iterator
from pathlib import Path

import pytest

from fes.errors import FesError
from tests.support.loop import load
from tests.support.teams import Team
from world.execution import resume
from world.execution.checkpoint import DIGEST_INPUT, FOLDER, STATE, CheckpointWriter
from world.execution.run import Run


@contextlib.contextmanager
def files_up_to(size: int) -> Iterator[None]:
    """Block in which no file can grow beyond `size` [bytes]: a write stops there, and the next one fails."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


@contextlib.contextmanager
def failing(name: str, number: int = 0) -> Iterator[None]:
    """Block in which a system call fails after `number` calls that succeed."""
    done, left = getattr(os, name), [number]

    def refused(*words: object) -> None:
        left[0] -= 1
        if left[0] < 0:
            raise OSError(5, "Input/output error")
        done(*words)

    with pytest.MonkeyPatch.context() as broken:
        broken.setattr(os, name, refused)
        yield


@pytest.fixture
def kept(tmp_path: Path) -> tuple[Run, CheckpointWriter]:
    """A run of five ticks, with a checkpoint of its first."""
    checkpoints = CheckpointWriter(tmp_path, 1e9, "pair", "main")
    run = Run(load("pair.toml"), note=checkpoints.note)
    checkpoints.begin(run)
    team = Team(run.scenario)
    for _ in range(5):
        team.step(run)
    return run, checkpoints


HOW = ["the disk is full", "the trail is not synced", "it is not synced", "it is not renamed"]


@pytest.mark.parametrize("how", HOW)
def test_a_failed_checkpoint_keeps_its_predecessor_and_the_whole_journal(
    tmp_path: Path, kept: tuple[Run, CheckpointWriter], how: str
) -> None:
    run, checkpoints = kept
    state = tmp_path / FOLDER / STATE
    before = state.read_bytes()
    broken = {
        HOW[0]: files_up_to(len(before) // 2),
        HOW[1]: failing("fsync"),
        HOW[2]: failing("fsync", 1),
        HOW[3]: failing("replace"),
    }
    with broken[how], pytest.raises(FesError, match=r"^cannot write a checkpoint: "):
        checkpoints.save(run, {}, 0.1, at_once=True)
    assert state.read_bytes() == before
    run.attend(run.world.ids != 1)  # noted in the new journal
    checkpoints.close(run)
    snapshot = resume.load(tmp_path)
    assert (snapshot.number, snapshot.state.tick) == (1, 0)
    again, other, _ = resume.run(tmp_path, snapshot, None, 1e9)
    assert again.state.tick == 5
    assert again.state.present.tolist() == [True, False]
    assert again.state.poses.tobytes() == run.state.poses.tobytes()
    assert again.metrics.link_errors.digest.text() == run.metrics.link_errors.digest.text()
    other.discard(again)


def test_a_checkpoint_replaces_its_predecessor_only_when_synced_to_disk(
    tmp_path: Path, kept: tuple[Run, CheckpointWriter], monkeypatch: pytest.MonkeyPatch
) -> None:
    run, checkpoints = kept
    synced: set[tuple[int, int]] = set()  # inode, and size
    fsync, replace, replaced = os.fsync, os.replace, list[tuple[int, int]]()

    def of(path: Path) -> tuple[int, int]:
        return path.stat().st_ino, path.stat().st_size

    def sync(number: int) -> None:
        fsync(number)
        synced.add((os.fstat(number).st_ino, os.fstat(number).st_size))

    def take_its_place(part: Path, whole: Path) -> None:
        replaced.append(of(part))
        assert replaced[-1] in synced
        assert of(tmp_path / FOLDER / DIGEST_INPUT) in synced  # the digest needs it
        replace(part, whole)

    monkeypatch.setattr(os, "fsync", sync)
    monkeypatch.setattr(os, "replace", take_its_place)
    checkpoints.save(run, {}, 0.1, at_once=True)
    checkpoints.close(run)
    assert replaced == [of(tmp_path / FOLDER / STATE)]
    assert sorted(path.name for path in (tmp_path / FOLDER).iterdir()) == ["journal-2", STATE, DIGEST_INPUT]
    assert resume.load(tmp_path).state.tick == 5
