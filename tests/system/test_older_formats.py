"""Files of older formats: each is rejected in one line that names both formats, and stays unchanged.

Files of the present formats by an earlier version of fes are read.

`python -m tests.system.test_older_formats` records the tables of a checkpoint of the present format.
"""

import re
import shutil
from collections import deque
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

import fes
from console.replay import compare, log
from console.replay.player import Player
from console.sweep import design, ledger
from console.terminal.keyboard import RIGHT
from fes.errors import FesError
from fes.protocol import messages
from fes.protocol.messages import Join
from fes.protocol.world_info import version
from fes.recording import schemas
from fes.recording.layout import NAME
from fes.recording.robot_log.layout import ROBOT_LOG
from fes.system import fingerprint
from tests.support.commands import call, complaint
from tests.support.loop import load
from tests.support.paths import FORMATS, PAIR
from tests.support.teams import Team
from world.execution import resume, snapshot
from world.execution.checkpoint import FOLDER, JOIN, STATE, CheckpointWriter
from world.execution.recorder import Recorder
from world.execution.run import Run


@pytest.fixture
def formats(tmp_path: Path) -> Path:
    """A copy of all files of older formats, written by versions up to 0.3.0."""
    return Path(shutil.copytree(FORMATS, tmp_path / "formats"))


def contents(where: Path) -> dict[Path, bytes]:
    return {path: path.read_bytes() for path in where.rglob("*") if path.is_file()}


@pytest.mark.parametrize("older", [2, 3, 4, 5, 6])
def test_a_checkpoint_of_an_older_format_is_rejected_in_one_line(formats: Path, older: int) -> None:
    run, before = formats / f"checkpoint-{older}", contents(formats)
    with pytest.raises(FesError) as caught:
        resume.load(run)
    assert str(caught.value) == f"{run / FOLDER / STATE} is a checkpoint of format {older}; this fes reads format 7"
    line = complaint(call(formats, "fes-world", "--resume", f"checkpoint-{older}"), "fes-world")
    assert line == f"checkpoint-{older}/checkpoint/state is a checkpoint of format {older}; this fes reads format 7"
    assert contents(formats) == before
    assert snapshot.FORMAT == 7


@pytest.mark.parametrize(
    ("run", "older"), [("log-1", 1), ("checkpoint-2", 1), ("log-2", 2), ("checkpoint-3", 2), ("checkpoint-4", 2)]
)
def test_a_log_of_an_older_version_is_rejected_in_one_line(formats: Path, run: str, older: int) -> None:
    with pytest.raises(FesError) as caught:
        log.load(formats / run)
    assert str(caught.value) == f"{formats / run / NAME} is a log of version {older}; this fes reads versions 3 and 4"
    assert (schemas.READABLE, schemas.VERSION) == (3, 4)


EARLIER = "fes 0.4.0 with arithmetic ec71240d0bea"
NOTE = f"recorded by {EARLIER}; this is {fingerprint.origin(version())}: the last digits shown may differ"


def test_a_log_that_release_0_4_wrote_is_read_shown_and_compared(
    formats: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    # That release had other elementary functions: a second execution has other last digits.
    recorded = log.load(formats / "log-3")
    assert recorded.origin == EARLIER
    with pytest.warns(UserWarning, match=f"{NAME} was {NOTE}"):
        result = fes.read(formats / "log-3", progress=False)
    assert recorded.summary is not None
    assert result.summary == recorded.summary
    *_, last = recorded.ticks()
    pose = messages.decode_observation(last.payloads.observations[1]).pose
    assert result.poses[-1, 1] == pytest.approx(pose, rel=1e-12)  # a few thousand roundings of 1e-16
    shown = Player(recorded, 1.0)
    shown.press(RIGHT)
    while shown.tick < 49:
        shown.advance(0.0)
    assert compare.compare(formats / "log-3", formats / "log-3") == 0
    assert capsys.readouterr().out == "every message of every tick is the same to the bit\n"


def test_a_robots_log_of_the_first_format_is_executed_again_to_the_bit(formats: Path) -> None:
    # of a robot that measures the channel, the laws of which have not changed since
    done = call(formats, "fes", "replay", "robot-log-1", "--robot=1")
    line = "robot 1, executed again: 50 ticks, the same to the bit\n"
    assert (done.returncode, done.stdout, done.stderr) == (0, line, "")
    assert ROBOT_LOG == 1


def test_the_programs_name_both_versions_where_a_log_of_release_0_4_is_executed_again(formats: Path) -> None:
    drawn = call(formats, "fes", "plot", "log-3")
    assert (drawn.returncode, drawn.stderr) == (0, f"fes: warning: log-3/{NAME} was {NOTE}\n")
    own = fingerprint.origin(version())
    for flag in ("--all", "--robot=1", "--headless"):
        again = call(formats, "fes", "replay", "log-3", flag)
        assert (again.returncode, again.stdout) == (1, "")
        error, note = again.stderr.splitlines()
        assert re.match(r"fes: error: tick \d+, .* in the log and .* executed again$", error)
        assert note == f"fes: recorded by {EARLIER}; executed by {own}"


def test_a_log_that_release_0_7_wrote_is_executed_again_to_the_bit(formats: Path) -> None:
    # Its payloads are of protocol 3, and say nothing of the tick of a fix.
    again = call(formats, "fes", "replay", "log-3-of-0.7", "--all")
    assert (again.returncode, again.stderr) == (0, "")
    assert "executed again: 50 ticks, the same to the bit" in again.stdout
    [first, *_] = log.load(formats / "log-3-of-0.7").ticks()
    assert messages.decode_observation(first.payloads.observations[1]).fixed == 0


def test_a_scenario_that_release_0_3_wrote_is_read(formats: Path) -> None:
    # it lists every key of [seeking], also those that its law does not use
    saved = load(str(formats / "scenario-0.3.toml"))
    assert saved == load("pair.toml", run__duration=60.0)


def test_a_sweep_without_a_format_is_rejected_in_one_line(formats: Path) -> None:
    before = contents(formats)
    planned = design.plan(Path(PAIR), [], "0:2", ["run.duration=1"])
    with pytest.raises(FesError) as caught, ledger.opened(formats / "sweep-1", planned):
        pass
    assert str(caught.value) == f"--out {formats / 'sweep-1'}: it holds a sweep of format 1; this fes reads format 2"
    assert contents(formats) == before
    assert ledger.FORMAT == 2


def tables(value: object) -> Iterator[tuple[str, str]]:
    """The name and the fields of each table of the project in a value."""
    if isinstance(value, dict):
        inner: list[object] = list(value.values())
    elif isinstance(value, list | tuple | deque):
        inner = list(value)
    else:
        inner = []
    kind = type(value)
    if kind.__module__.split(".")[0] in ("fes", "world"):
        names = getattr(value, "_fields", getattr(kind, "model_fields", getattr(value, "__dataclass_fields__", None)))
        fields = list(vars(value) if names is None else names)
        yield f"{kind.__module__}.{kind.__qualname__}", " ".join(sorted(fields))
        inner += [getattr(value, name) for name in fields]
    for item in inner:
        yield from tables(item)


def layout(where: Path) -> str:
    """All tables in a checkpoint, one per line."""
    bursts = {"bad_share": 0.2, "mean_length": 0.1}
    noisy = {"sensing__pose_noise": 1.0, "sensing__pose_latency": 0.04, "robots__slip": 0.05}
    scenario = load("measured.toml", run__duration=0.2, channel__bursts=bursts, objective__team_index=True, **noisy)
    (where / "run").mkdir()
    with Recorder(where / "run" / NAME, scenario, "x", "processes") as recorder:
        checkpoints, team = CheckpointWriter(where / "run", 1e9, "x", "main"), Team(scenario)
        run = Run(scenario, recorder, checkpoints.note)
        checkpoints.begin(run)
        checkpoints.note([JOIN, [0, 1], 7])
        for _ in range(5):
            team.step(run)
        checkpoints.save(run, {0: Join((0, 1), 7)}, 0.1, at_once=True)
        saved = resume.load(where / "run")
        checkpoints.discard(run)
    return "".join(f"{name}: {names}\n" for name, names in sorted(set(tables(saved))))


LAYOUT = FORMATS / f"checkpoint-{snapshot.FORMAT}.txt"


def test_no_table_of_a_checkpoint_changes_without_a_new_format_number(tmp_path: Path) -> None:
    # A checkpoint names its format, not the version of the package: with other tables the resumed run would fail.
    advice = "raise world.execution.snapshot.FORMAT, then python -m tests.system.test_older_formats"
    wanted = f"other tables in a checkpoint: {advice}"
    assert layout(tmp_path) == LAYOUT.read_text(encoding="utf-8"), wanted


def test_the_stored_files_of_older_formats_are_small_and_complete() -> None:
    names = [
        "checkpoint-2",
        "checkpoint-3",
        "checkpoint-4",
        "checkpoint-5",
        "checkpoint-6",
        LAYOUT.name,
        "log-1",
        "log-2",
        "log-3",
        "log-3-of-0.7",
        "robot-log-1",
        "scenario-0.3.toml",
        "sweep-1",
    ]
    assert sorted(path.name for path in FORMATS.iterdir()) == names
    assert all(len(content) < 100_000 for content in contents(FORMATS).values())


if __name__ == "__main__":
    with TemporaryDirectory() as folder:
        LAYOUT.write_text(layout(Path(folder)), encoding="utf-8")
