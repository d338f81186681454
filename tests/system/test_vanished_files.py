"""Files that are removed or cut during a run are named at its end; the run loses nothing else."""

import contextlib
import json
import os
import shutil
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest

from console.backends import inprocess
from console.replay import command as replay_command
from console.replay import log
from fes.errors import FesError
from fes.recording.layout import NAME
from fes.recording.writer.log_file import LogFile
from tests.support.loop import load
from tests.support.paths import PAIR
from tests.support.processes import fes, start, until
from tests.support.teams import Team
from world.execution import resume
from world.execution.checkpoint import DIGEST_INPUT, FOLDER, STATE, CheckpointWriter
from world.execution.recorder import Recorder
from world.execution.run import Run


def grow(path: Path) -> None:
    with path.open("ab") as file:
        file.write(b"x")


HOW: dict[str, tuple[Callable[[Path], object], str]] = {
    "removed": (os.unlink, "was removed"),
    "cut": (lambda path: os.truncate(path, 100), r"was cut by [\d,]+ bytes"),
    "replaced": (lambda path: (path.rename(f"{path}.old"), shutil.copy(f"{path}.old", path)), "was replaced"),
    "written to": (grow, r"was written to by another program: .* bytes, not .*"),
}


@pytest.mark.parametrize("how", HOW)
@pytest.mark.parametrize("chunks", [True, False], ids=["chunks follow", "at the end"])
def test_a_log_changed_during_its_run_is_reported_at_the_end(tmp_path: Path, how: str, chunks: bool) -> None:
    scenario, path = load("pair.toml", run__duration=0.4), tmp_path / NAME
    change, expected = HOW[how]
    with contextlib.ExitStack() as stack:
        recorder = stack.enter_context(Recorder(path, scenario, "pair", "inprocess"))
        run, team = Run(scenario, recorder), Team(scenario)
        while not run.is_over:
            if run.state.tick == 10:
                recorder.pause()
                change(path)
            team.step(run)
            if run.state.tick == 15 and chunks:
                recorder.pause()  # a chunk written at the old end would turn the cut into a hole
        with pytest.raises(FesError, match=rf"^{path} {expected} during the run: the log is incomplete$"):
            stack.close()
    assert run.metrics.link_errors.digest.text() == inprocess.run(scenario, "pair")["digest"]


def test_the_error_of_a_log_does_not_hide_the_error_of_its_run(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    recorder = Recorder(tmp_path / NAME, load("pair.toml"), "pair", "inprocess")
    (tmp_path / NAME).unlink()
    with pytest.raises(FesError, match=r"^it was the disk$"), recorder:
        raise FesError("it was the disk")
    assert "run.mcap was removed during the run" in caplog.text


def test_a_run_whose_log_vanishes_exits_with_1_and_keeps_its_summary(tmp_path: Path) -> None:
    running = start(fes("run", PAIR, "--duration", "2", "--rtf", "1", "--headless", "--out", "out"), tmp_path)
    path = tmp_path / "out" / NAME
    until(lambda: path.exists() and path.stat().st_size)
    path.unlink()
    out, err = running.communicate(timeout=60)
    assert (running.returncode, out) == (1, "")
    assert err.endswith("fes: error: fes-world: out/run.mcap was removed during the run: the log is incomplete\n")
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["digest"] == inprocess.run(load("pair.toml", run__duration=2.0), "pair")["digest"]


KINDS = ["the trail", "the journal", "the state", "the folder"]


@pytest.mark.parametrize("what", KINDS)
def test_a_checkpoint_changed_during_its_run_is_reported_at_the_end(
    tmp_path: Path, what: str, caplog: pytest.LogCaptureFixture
) -> None:
    scenario = load("pair.toml", run__duration=0.4)
    checkpoints = CheckpointWriter(tmp_path, 1e9, "pair", "main")
    run, team = Run(scenario, note=checkpoints.note), Team(scenario)
    checkpoints.begin(run)
    folder = tmp_path / FOLDER
    removed = dict(zip(KINDS, (folder / DIGEST_INPUT, folder / "journal-1", folder / STATE), strict=False))
    while not run.is_over:
        if run.state.tick == 10:
            assert checkpoints.losses(run) == []
            if what in removed:
                removed[what].unlink()
            else:
                shutil.rmtree(folder)
        team.step(run)
    checkpoints.discard(run)
    lines = [
        line
        for line in caplog.text.splitlines()
        if "during the run: from then on the run could not have been resumed" in line
    ]
    assert len(lines) == (3 if what == "the folder" else 1)
    assert all(str(removed.get(what, folder)) in line for line in lines)
    assert run.metrics.link_errors.digest.text() == inprocess.run(scenario, "pair")["digest"]


def test_no_checkpoint_is_written_without_its_digest_input(tmp_path: Path) -> None:
    checkpoints = CheckpointWriter(tmp_path, 1e9, "pair", "main")
    run = Run(load("pair.toml"), note=checkpoints.note)
    checkpoints.begin(run)
    team = Team(run.scenario)
    for _ in range(5):
        team.step(run)
    assert checkpoints.losses(run) == []  # flushes pending data
    os.truncate(tmp_path / FOLDER / DIGEST_INPUT, 0)
    team.step(run)
    with pytest.raises(FesError, match=r"^cannot write a checkpoint: .*trail was cut by \d+ bytes$"):
        checkpoints.save(run, {}, 0.1, at_once=True)
    checkpoints.discard(run)


def test_a_log_set_aside_stays_until_its_copy_was_read_back(tmp_path: Path) -> None:
    scenario = load("pair.toml", run__duration=0.4)
    first = tmp_path / "first"
    first.mkdir()
    team = Team(scenario)
    with Recorder(first / NAME, scenario, "pair", "processes") as recorder:
        checkpoints = CheckpointWriter(first, 1e9, "pair", "main")
        original_run = Run(scenario, recorder, checkpoints.note)
        checkpoints.begin(original_run)
        for _ in range(10):
            team.step(original_run)
        checkpoints.save(original_run, {}, 0.1, at_once=True)
        shutil.copytree(first, tmp_path / "killed")
        checkpoints.discard(original_run)
    run = tmp_path / "killed"
    original = (run / NAME).read_bytes()
    kept = resume.load(run)
    aside = run / FOLDER / f"log-{kept.number}"

    # A copy with other content is rejected, and the original stays in its place.
    with pytest.MonkeyPatch.context() as broken:
        broken.setattr("fes.recording.mcap_file.McapFile._add_copy", lambda *words: None)
        broken.setattr("world.execution.resume.Recorder", partial(Recorder, writer=LogFile))
        with pytest.raises(FesError, match=r"cannot be continued: .*run\.mcap does not hold what was copied to it$"):
            resume.recorder(run, kept)
    assert (run / NAME).read_bytes() == original
    assert not aside.exists()

    # A world that dies before its first checkpoint leaves the log set aside for its successor.
    for _ in range(2):
        again = resume.recorder(run, resume.load(run))
        assert again is not None
        assert aside.read_bytes() == original
        with contextlib.suppress(FesError), again:
            raise FesError("it died")

    # Once a checkpoint knows the copy, the original is not needed.
    kept = resume.load(run)
    recorder_ = resume.recorder(run, kept)
    assert recorder_ is not None
    with recorder_:
        other, checkpoints, _ = resume.run(run, kept, recorder_, 1e9)
        assert not aside.exists()
        while not other.is_over:
            team.step(other)
        checkpoints.discard(other)
    assert replay_command.rerun(log.load(run))["digest"] == other.metrics.link_errors.digest.text()
