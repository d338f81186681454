"""Files of older formats: each is rejected in one line that names both formats, and stays unchanged.

`python -m tests.system.test_older_formats` records which tables a checkpoint of the present format holds.
"""

import shutil
from collections import deque
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

from console.replay import log
from console.sweep import design, ledger
from fes.errors import FesError
from fes.protocol.messages import Join
from fes.recording import schemas
from fes.recording.layout import NAME
from tests.support.commands import call, complaint
from tests.support.loop import load
from tests.support.paths import FORMATS, PAIR
from tests.support.teams import Team
from world.execution import resume, snapshot
from world.execution.checkpoint import FOLDER, JOIN, STATE, CheckpointWriter
from world.execution.recorder import Recorder
from world.execution.run import Run

KEPT = FORMATS


@pytest.fixture
def kept(tmp_path: Path) -> Path:
    """A copy of all stored files, as version 0.2.0 wrote them."""
    return Path(shutil.copytree(KEPT, tmp_path / "formats"))


def contents(where: Path) -> dict[Path, bytes]:
    return {path: path.read_bytes() for path in where.rglob("*") if path.is_file()}


def test_a_checkpoint_of_format_2_is_rejected_in_one_line(kept: Path) -> None:
    run, before = kept / "checkpoint-2", contents(kept)
    with pytest.raises(FesError) as caught:
        resume.load(run)
    assert str(caught.value) == f"{run / FOLDER / STATE} is a checkpoint of format 2; this fes reads format 3"
    line = complaint(call(kept, "fes-world", "--resume", "checkpoint-2"), "fes-world")
    assert line == "checkpoint-2/checkpoint/state is a checkpoint of format 2; this fes reads format 3"
    assert contents(kept) == before
    assert snapshot.FORMAT == 3


def test_a_log_of_version_1_is_rejected_in_one_line(kept: Path) -> None:
    for run in (kept / "log-1", kept / "checkpoint-2"):
        with pytest.raises(FesError) as caught:
            log.load(run)
        assert str(caught.value) == f"{run / NAME} is a log of version 1; this fes reads version 2"
    assert schemas.VERSION == 2


def test_a_sweep_without_a_format_is_rejected_in_one_line(kept: Path) -> None:
    before = contents(kept)
    planned = design.plan(Path(PAIR), [], "0:2", ["run.duration=1"])
    with pytest.raises(FesError) as caught, ledger.opened(kept / "sweep-1", planned):
        pass
    assert str(caught.value) == f"--out {kept / 'sweep-1'}: it holds a sweep of format 1; this fes reads format 2"
    assert contents(kept) == before
    assert ledger.FORMAT == 2


def tables(value: object) -> Iterator[tuple[str, str]]:
    """Name and fields of each table of the project in a value."""
    if isinstance(value, dict):
        inner: list[object] = list(value.values())
    elif isinstance(value, list | tuple | deque):
        inner = list(value)
    else:
        inner = []
    kind = type(value)
    if kind.__module__.split(".")[0] in ("fes", "world"):
        names = getattr(value, "_fields", getattr(kind, "model_fields", getattr(value, "__dataclass_fields__", None)))
        found = list(vars(value) if names is None else names)
        yield f"{kind.__module__}.{kind.__qualname__}", " ".join(sorted(found))
        inner += [getattr(value, name) for name in found]
    for one in inner:
        yield from tables(one)


def layout(where: Path) -> str:
    """All tables in a checkpoint, one line per table."""
    scenario = load("measured.toml", run__duration=0.2, channel__bursts={"bad_share": 0.2, "mean_length": 0.1})
    (where / "run").mkdir()
    with Recorder(where / "run" / NAME, scenario, "x", "processes") as recorder:
        run, checkpoints, team = (
            Run(scenario, recorder),
            CheckpointWriter(where / "run", 1e9, "x", "main"),
            Team(scenario),
        )
        checkpoints.begin(run)
        checkpoints.note([JOIN, [0, 1], 7])
        for _ in range(5):
            team.step(run)
        checkpoints.save(run, {0: Join((0, 1), 7)}, 0.1, at_once=True)
        kept = resume.load(where / "run")
        checkpoints.discard(run)
    return "".join(f"{name}: {names}\n" for name, names in sorted(set(tables(kept))))


LAYOUT = KEPT / f"checkpoint-{snapshot.FORMAT}.txt"


def test_no_table_of_a_checkpoint_changes_without_a_new_format_number(tmp_path: Path) -> None:
    # A checkpoint names its format, not the package's version: changed tables would fail during the run.
    advice = "raise world.execution.snapshot.FORMAT, then python -m tests.system.test_older_formats"
    wanted = f"other tables in a checkpoint: {advice}"
    assert layout(tmp_path) == LAYOUT.read_text(encoding="utf-8"), wanted


def test_every_stored_format_is_tested() -> None:
    assert sorted(path.name for path in KEPT.iterdir()) == ["checkpoint-2", LAYOUT.name, "log-1", "sweep-1"]
    assert all(len(content) < 100_000 for content in contents(KEPT).values())


if __name__ == "__main__":
    with TemporaryDirectory() as folder:
        LAYOUT.write_text(layout(Path(folder)), encoding="utf-8")
