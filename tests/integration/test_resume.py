"""Runs resumed from a checkpoint: after every tick of one loop, and not from a damaged one."""

import shutil
from contextlib import suppress
from pathlib import Path

import pytest
from mcap.reader import make_reader

from console.replay import command as replay_command
from console.replay import log
from fes.errors import FesError
from fes.recording.layout import NAME
from tests.support.loop import load
from tests.support.teams import Team
from world.execution import resume
from world.execution.checkpoint import FOLDER, CheckpointWriter
from world.execution.recorder import Recorder
from world.execution.run import Run
from world.metrics import summary


def messages_of(path: Path) -> list[tuple[str, int, bytes]]:
    """Every message of a log until it ends: topic, tick and payload."""
    with path.open("rb") as file:
        read = make_reader(file).iter_messages(log_time_order=False)
        result = [(channel.topic, message.sequence, message.data) for _, channel, message in read]
    [end] = [index for index, (topic, _, data) in enumerate(result) if topic == "/events" and b'"end"' in data]
    return result[:end]


@pytest.mark.parametrize("name", ["paper.toml", "measured.toml"])
@pytest.mark.parametrize("recorded", [True, False], ids=["recorded", "not recorded"])
def test_a_run_can_be_resumed_after_every_tick(tmp_path: Path, name: str, recorded: bool) -> None:
    bursts = {"bad_share": 0.2, "mean_length": 0.1}
    faults = [
        {"at": 0.3, "transmitter": {"robot": 2, "loss": 0.5}},
        {"at": 0.5, "transmitter": {"robot": 3, "corrupt": True}},
    ]
    scenario = load(name, run__duration=0.8, channel__bursts=bursts, event=faults)
    first, second = tmp_path / "first", tmp_path / "second"
    first.mkdir()
    team, logs = Team(scenario), dict[int, list[tuple[str, int, bytes]]]()
    with Recorder(first / NAME, scenario, name, "processes") as recorder:
        checkpoints = CheckpointWriter(first, 1e9, name, "main")
        run = Run(scenario, recorder if recorded else None, checkpoints.note)
        checkpoints.begin(run)
        for tick in range(scenario.ticks):
            if tick == 13:
                run.change("channel.reference_snr", 2e6)
            if tick == 20:  # a robot leaves and rejoins within a tick
                everybody = run.state.present
                run.attend(everybody & (run.world.ids != 2))
                run.attend(everybody)
            if tick % 7 == 5:
                checkpoints.save(run, {}, 0.1, at_once=True)
            team.step(run)
            shutil.rmtree(second, ignore_errors=True)
            shutil.copytree(first, second)
            snapshot = resume.load(second)
            assert snapshot.state.tick == max(0, (tick + 2) // 7 * 7 - 2 if tick >= 5 else 0)
            again = resume.recorder(second, snapshot)
            assert (again is not None) == recorded
            other, kept, elapsed = resume.run(second, snapshot, again, 1e9)
            assert other.state.tick == tick + 1
            assert elapsed == 0.1  # the value of every tick
            assert other.state.poses.tobytes() == run.state.poses.tobytes()
            assert other.state.radio.burst.tobytes() == run.state.radio.burst.tobytes()
            assert other.state.channel == run.state.channel
            assert other.scenario == run.scenario
            assert other.metrics.link_errors.digest.text() == run.metrics.link_errors.digest.text()
            assert summary.summarize(other.metrics, name, "", 0.1) == summary.summarize(run.metrics, name, "", 0.1)
            if again is not None:
                with suppress(FesError), again:
                    raise FesError("it was stopped")
                loaded = log.load(second / NAME)
                assert sum(1 for _ in loaded.ticks()) == tick + 1
                again_of_it = replay_command.rerun(loaded, all_robots=True)
                assert again_of_it["digest"] == run.metrics.link_errors.digest.text()
                logs[tick] = messages_of(second / NAME)
            kept.discard(other)
            assert not (second / FOLDER).exists()
        checkpoints.discard(run)
    if recorded:
        whole_log = messages_of(first / NAME)
        assert {topic for topic, *_ in whole_log} >= {"/events", "/report"}
        for tick, result in logs.items():
            assert result == whole_log[: len(result)], tick
        assert len(result) == len(whole_log)


def test_a_damaged_log_is_reported_in_one_line(tmp_path: Path) -> None:
    scenario = load("pair.toml", run__duration=0.2)
    team, checkpoints = Team(scenario), CheckpointWriter(tmp_path, 1e9, "pair", "main")
    with suppress(FesError), Recorder(tmp_path / NAME, scenario, "pair", "processes") as recorder:
        run = Run(scenario, recorder, checkpoints.note)
        checkpoints.begin(run)
        for _ in range(5):
            team.step(run)
        checkpoints.save(run, {}, 0.1, at_once=True)
        checkpoints.close(run)
        raise FesError("it was stopped")
    content, snapshot = (tmp_path / NAME).read_bytes(), resume.load(tmp_path)
    assert snapshot.log is not None
    for damaged in (b"", content[: snapshot.log.size // 2], content[: snapshot.log.size - 1], b"x" + content[1:]):
        (tmp_path / FOLDER / f"log-{snapshot.number}").unlink(missing_ok=True)
        (tmp_path / NAME).write_bytes(damaged)
        for gone_on_with in (lambda: resume.load(tmp_path), lambda: resume.recorder(tmp_path, snapshot)):
            with pytest.raises(FesError, match=r"(run\.mcap|log-2) is (damaged at byte|not a log: )"):
                gone_on_with()
            assert (tmp_path / NAME).read_bytes() == damaged  # the original stays
            assert not (tmp_path / FOLDER / "log-2").exists()
