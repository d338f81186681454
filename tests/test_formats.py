"""Files of older formats: each is refused in one line that names both, and stays as it was."""

import shutil
from pathlib import Path

import pytest

from console import log
from console.sweep import design, ledger
from fes.errors import FesError
from tests.test_cli import PAIR, call, complaint
from world import resume, schemas, snapshot
from world.checkpoint import FOLDER, STATE
from world.recorder import NAME

KEPT = Path(__file__).parent / "formats"


@pytest.fixture
def kept(tmp_path: Path) -> Path:
    """A copy of all of them, as version 0.2.0 wrote them."""
    return Path(shutil.copytree(KEPT, tmp_path / "formats"))


def contents(where: Path) -> dict[Path, bytes]:
    return {path: path.read_bytes() for path in where.rglob("*") if path.is_file()}


def test_a_checkpoint_of_format_2(kept: Path) -> None:
    run, before = kept / "checkpoint-2", contents(kept)
    with pytest.raises(FesError) as caught:
        resume.load(run)
    assert str(caught.value) == f"{run / FOLDER / STATE} is a checkpoint of format 2; this fes reads format 3"
    line = complaint(call(kept, "fes-world", "--resume", "checkpoint-2"), "fes-world")
    assert line == "checkpoint-2/checkpoint/state is a checkpoint of format 2; this fes reads format 3"
    assert contents(kept) == before
    assert snapshot.FORMAT == 3


def test_a_log_of_version_1(kept: Path) -> None:
    for run in (kept / "log-1", kept / "checkpoint-2"):
        with pytest.raises(FesError) as caught:
            log.load(run)
        assert str(caught.value) == f"{run / NAME} is a log of version 1; this fes reads version 2"
    assert schemas.VERSION == 2


def test_a_sweep_without_a_format(kept: Path) -> None:
    before = contents(kept)
    planned = design.plan(Path(PAIR), [], "0:2", ["run.duration=1"])
    with pytest.raises(FesError) as caught, ledger.opened(kept / "sweep-1", planned):
        pass
    assert str(caught.value) == f"--out {kept / 'sweep-1'}: it holds a sweep of format 1; this fes reads format 2"
    assert contents(kept) == before
    assert ledger.FORMAT == 2


def test_all_that_is_kept_is_tried() -> None:
    assert sorted(path.name for path in KEPT.iterdir()) == ["checkpoint-2", "log-1", "sweep-1"]
    assert all(len(content) < 100_000 for content in contents(KEPT).values())
