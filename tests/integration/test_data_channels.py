"""Runs whose channel is data: the same digits in one loop and over a bus, replayed, resumed and changed."""

import asyncio
import shutil
from pathlib import Path
from typing import Any

import pytest

from console.backends import inprocess
from console.replay import command as replay_command
from console.replay import log
from fes.errors import FesError, Rejected, ScenarioError
from fes.protocol import channel_change, keys
from fes.protocol.channel_change import ParameterChange
from tests.support import commands, recordings, session
from tests.support.loop import load
from tests.support.processes import PATIENCE
from tests.support.teams import Team
from world.config import remarks
from world.config.scenario import Scenario
from world.execution import resume
from world.execution.checkpoint import CheckpointWriter
from world.execution.recorder import Recorder
from world.execution.run import Run
from world.metrics import summary as summaries

PAIRS = [(0, 1), (1, 0)]
ROWS = [[10.0, 1.0], [70.0, 0.5], [120.0, 0.75]]


def trace(folder: Path) -> Path:
    """A trace of two robots, whose reception alternates each 0.1 s."""
    lines = ["time,sender,receiver,probability"]
    lines += [f"{0.1 * step:g},{a},{b},{0.3 + 0.6 * (step % 2)}" for step in range(20) for a, b in PAIRS]
    path = folder / "links.csv"
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


def pair(folder: Path, model: str = "trace", **overrides: Any) -> Scenario:
    """Two robots that count beacons, and a scenario that has both rows and a trace."""
    data = {"channel__model": model, "channel__rows": ROWS, "channel__trace": str(trace(folder))}
    return load("pair.toml", **{"run__duration": 2.0, "seeking__index": "measured", **data, **overrides})


@pytest.mark.parametrize("model", ["trace", "table"])
@pytest.mark.parametrize("between", ["held", "interpolated"])
def test_robots_on_a_bus_and_robots_in_one_loop_have_one_digest(tmp_path: Path, model: str, between: str) -> None:
    scenario = pair(tmp_path, model, channel__trace_between=between)
    alone = inprocess.run(scenario, "pair")
    connected, _, _ = asyncio.run(asyncio.wait_for(session.run(scenario, [[0], [1]]), PATIENCE))
    assert connected["digest"] == alone["digest"]
    assert connected["beacons_decoded"] == alone["beacons_decoded"]
    assert alone["digest"] != inprocess.run(pair(tmp_path, "rayleigh"), "pair")["digest"]


def test_reception_follows_the_trace_and_not_the_separation(tmp_path: Path) -> None:
    summary = inprocess.run(pair(tmp_path), "pair")
    assert summary["optimal_separation"] is None or summary["optimal_separation"] != summary["optimal_separation"]
    # half of the time 0.3, half of the time 0.9; 2 beacons per tick from tick 1 on
    sent = summary["beacons_sent"]
    sigma = (0.25 * sent) ** 0.5
    assert sent == 2 * 98
    assert summary["beacons_decoded"] == pytest.approx(0.6 * sent, abs=4 * sigma)  # binomial, at most


def test_a_log_is_replayed_with_its_trace_and_refused_with_another(tmp_path: Path) -> None:
    recordings.record(tmp_path / "run.mcap", pair(tmp_path))
    replay_command.rerun(log.load(tmp_path / "run.mcap"), all_robots=True)
    path = tmp_path / "links.csv"
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace("0.3", "0.4", 1), encoding="utf-8")
    refused = commands.complaint(commands.call(tmp_path, "fes", "replay", "run.mcap"), "fes")
    assert refused.startswith(f"{path} has changed: its SHA-256 is ")
    path.unlink()
    refused = commands.complaint(commands.call(tmp_path, "fes", "replay", "run.mcap"), "fes")
    assert refused == f"trace {path} cannot be read: No such file or directory"


def test_the_scenario_of_a_run_directory_repeats_the_run_from_another_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scenario = pair(tmp_path)
    (tmp_path / "run").mkdir()
    summaries.write_scenario(tmp_path / "run", scenario)
    monkeypatch.chdir("/")
    again = load(str(tmp_path / "run" / "scenario.toml"))
    assert again == scenario
    assert inprocess.run(again, "pair")["digest"] == inprocess.run(scenario, "pair")["digest"]


def test_a_run_resumes_with_its_trace_and_not_with_another(tmp_path: Path) -> None:
    scenario, first = pair(tmp_path), tmp_path / "first"
    first.mkdir()
    team = Team(scenario)
    checkpoints = CheckpointWriter(first, 1e9, "pair", "main")
    run = Run(scenario, None, checkpoints.note)
    checkpoints.begin(run)
    for tick in range(60):
        if tick == 20:
            checkpoints.save(run, {}, 0.1, at_once=True)
        if tick == 40:
            run.change("channel.model", "table")
        if tick == 50:
            run.change("channel.model", "trace")
        team.step(run)
    checkpoints.close(run)
    for copy in ("second", "third"):
        shutil.copytree(first, tmp_path / copy)
    again, kept, _ = resume.run(tmp_path / "second", resume.load(tmp_path / "second"), None, 1e9)
    kept.close(again)
    assert again.state.tick == 60
    assert again.metrics.link_errors.digest.text() == run.metrics.link_errors.digest.text()
    path = tmp_path / "links.csv"
    path.write_text(path.read_text(encoding="utf-8") + "\n9,0,1,0", encoding="utf-8")
    with pytest.raises(FesError, match=r"^\S*links\.csv has changed: "):
        resume.run(tmp_path / "third", resume.load(tmp_path / "third"), None, 1e9)


CHANGES = [
    ("channel.model", "table", None),
    ("channel.rows", [[10.0, 0.0], [90.0, 0.25]], None),
    ("channel.model", "rayleigh", None),
    ("channel.model", "trace", None),
    ("channel.trace_between", "interpolated", None),
    ("channel.trace", "/etc/hostname", "channel.trace: cannot be set during a run: name the file in the scenario"),
    ("channel.trace_sha256", "0", "channel.trace_sha256: cannot be set during a run: name the file in the scenario"),
    ("channel.model", "tarce", "there is no channel 'tarce'; did you mean 'trace'?"),
    ("channel.model", "no_module:Channel", "this process was not told to use module 'no_module'"),
    ("channel.rows", [], None),  # no rows are needed by a trace
    ("channel.model", "table", "the channel: rows: model 'table' needs at least two, got 0"),
    ("channel.shadowing.deviation", 4.0, "the channel: shadowing acts on separations, which a trace does not have"),
]


def test_fes_set_changes_the_channel_to_data_and_back_or_refuses_in_one_line(tmp_path: Path) -> None:
    scenario = pair(tmp_path, "rayleigh", run__duration=20.0)
    answers: list[str | None] = []
    optima = []

    async def disturb(endpoint: str, begin: asyncio.Event) -> None:
        async with session.client(endpoint) as person:
            begin.set()
            for path, value, _ in CHANGES:
                payload = channel_change.encode_change(ParameterChange(path, value))
                try:
                    answer = await person.get(keys.change(session.RUN), payload, PATIENCE)
                    optima.append(channel_change.decode_result(answer).optimal_separation)
                    answers.append(None)
                except Rejected as error:
                    answers.append(str(error))

    async def run() -> dict[str, Any]:
        with Recorder(tmp_path / "run.mcap", scenario, "test", "processes") as recorder:
            summary, _, _ = await session.run(scenario, [[0], [1]], disturb, recorder)
            recorder.conclude(summary)
        return summary

    summary = asyncio.run(asyncio.wait_for(run(), PATIENCE))
    for answer, (path, _, expected) in zip(answers, CHANGES, strict=True):
        if expected is None:
            assert answer is None, path
        else:
            assert answer is not None, path
            assert expected in answer
            assert "\n" not in answer
    # table, other rows, rayleigh, then a trace three times
    assert [value == value for value in optima] == [True, True, True, False, False, False]
    assert optima[2] == pytest.approx(68.114, abs=1e-3)
    assert replay_command.rerun(log.load(tmp_path / "run.mcap"), all_robots=True)["digest"] == summary["digest"]


def test_a_change_that_is_refused_leaves_the_run_as_it_was(tmp_path: Path) -> None:
    notes: list[list[Any]] = []
    run = Run(pair(tmp_path), None, notes.append)
    channel, scenario = run.state.channel, run.scenario
    for path, value, expected in CHANGES:
        if expected is not None and path != "channel.model":
            with pytest.raises(ScenarioError):
                run.change(path, value)
    with pytest.raises(ScenarioError, match="there is no channel 'tarce'"):
        run.change("channel.model", "tarce")
    assert (run.state.channel, run.scenario, notes) == (channel, scenario, [])


def test_data_that_no_channel_uses_is_remarked_on(tmp_path: Path) -> None:
    said = remarks.of(pair(tmp_path, "rayleigh"))
    assert said == [
        "channel.rows has no effect: channel.model is 'rayleigh', not 'table'",
        "channel.trace has no effect: channel.model is 'rayleigh', not 'trace'",
    ]
    later = [{"at": 1.0, "set": {"channel.model": "table"}}]
    assert remarks.of(pair(tmp_path, event=later)) == []
