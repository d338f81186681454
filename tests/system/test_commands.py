"""The installed commands, called by a person or a script: output, files and exit codes."""

import io
import json
import tomllib
from pathlib import Path

import pytest
import typer.main
from rich.console import Console

from console import cli
from console.backends import inprocess
from console.dashboard import summary
from tests.support.commands import call, complaint, run_json, vacant
from tests.support.loop import load
from tests.support.paths import CONFIGS, PAIR, ROOT
from tests.support.processes import LOOP

ROBOT = str(ROOT / "deploy/robots/robot.toml")


def test_a_run_prints_one_summary_and_leaves_it_in_the_latest_run_directory(tmp_path: Path) -> None:
    first = run_json(tmp_path, "--duration", "2")
    assert (first["ticks"], first["seed"], first["backend"]) == (100, 1, "inprocess")
    assert first["digest"] == inprocess.run(load("pair.toml", run__duration=2), "pair")["digest"]
    runs = tmp_path / "runs"
    assert (runs / "latest").readlink() == Path("pair-1")
    assert {path.name for path in (runs / "pair-1").iterdir()} == {"scenario.toml", "summary.json", "run.mcap"}
    assert json.loads((runs / "latest" / "summary.json").read_text()) == first

    again = run_json(tmp_path, "--duration", "2", "--seed", "7", "--set", "channel.model=perfect")
    assert (again["seed"], again["beacons_sent"]) == (7, again["beacons_decoded"])
    assert again["digest"] != first["digest"]
    assert (runs / "latest").readlink() == Path("pair-2")
    effective = tomllib.loads((runs / "latest" / "scenario.toml").read_text())
    assert (effective["run"]["seed"], effective["run"]["duration"]) == (7, 2.0)
    assert effective["channel"]["model"] == "perfect"
    assert json.loads((runs / "pair-1" / "summary.json").read_text()) == first


def test_the_requested_directory_is_created_and_never_overwritten(tmp_path: Path) -> None:
    out = tmp_path / "a" / "b"
    run_summary = run_json(tmp_path, "--duration", "1", "--out", str(out), "--rtf", "5")
    assert json.loads((out / "summary.json").read_text()) == run_summary
    assert run_summary["wall_s"] >= 0.199  # one simulated second, five reports per second
    assert not (tmp_path / "runs").exists()
    done = call(tmp_path, "fes", "run", PAIR, "--backend", "inprocess", "--out", str(out))
    assert complaint(done, "fes") == f"--out {out}: the directory is not empty"
    assert json.loads((out / "summary.json").read_text()) == run_summary


def test_a_run_prints_its_result_and_its_directory(tmp_path: Path) -> None:
    words = ("run", PAIR, "--backend", "inprocess", "--headless", "--duration", "1", "--verbose")
    done = call(tmp_path, "fes", *words)
    assert (done.returncode, done.stderr) == (0, LOOP.format(2))
    run_summary = json.loads((tmp_path / "runs" / "latest" / "summary.json").read_text())
    assert "pair, 2 robots, seed 1, inprocess" in done.stdout
    assert f"{run_summary['edges'][0][2]:.3f}" in done.stdout
    assert done.stdout.splitlines()[-2] == "run directory: runs/pair-1"


@pytest.mark.parametrize("part", ["digest", "unit"])
def test_the_tables_show_the_whole_digest_and_the_units(part: str) -> None:
    run_summary = inprocess.run(load("pair.toml", run__duration=1), "pair")
    screen = Console(width=80, file=io.StringIO())
    screen.print(summary.render(run_summary, verbose=True))
    assert isinstance(screen.file, io.StringIO)
    assert {"digest": run_summary["digest"], "unit": "separation [m]"}[part] in screen.file.getvalue()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["run", "nowhere.toml"], ["nowhere.toml", "No such file"]),
        (["run", str(CONFIGS)], ["configs", "Is a directory"]),
        (["run"], ["Missing argument 'SCENARIO'; see ", "run --help"]),
        (["run", PAIR, "--set", "run.durration=3"], ["'run.durration'", "'run.duration'"]),
        (["run", PAIR, "--set", "run.seed=soon"], ["run.seed", "integer", "'soon'"]),
        (["run", PAIR, "--set", "channel.communication_range=-1"], ["channel.communication_range", "-1"]),
        (["run", PAIR, "--set", "run.seed"], ["--set", "table.field=value", "'run.seed'"]),
        (["run", PAIR, "--set", "run.dt.x=1"], ["--set", "'run.dt.x'", "not a table"]),
        (["run", PAIR, "--duration", "nan"], ["run.duration", "must be", "nan"]),
        (["run", PAIR, "--seed", "-1"], ["run.seed", "-1"]),
        (["run", PAIR, "--seed", "x"], ["--seed", "integer"]),
        (["run", PAIR, "--rtf", "0"], ["--rtf", "'max'", "'0'"]),
        (["run", PAIR, "--rtf", "nan"], ["--rtf", "'max'", "'nan'"]),
        (["run", PAIR, "--clock", "slow"], ["--clock", "'slow'", "'lockstep'", "'live'"]),
        (["run", PAIR, "--backend", "threads"], ["--backend", "'threads'", "'inprocess'"]),
        (["run", PAIR, "--agents-per-process", "0"], ["--agents-per-process", "1"]),
        (["run", PAIR, "--fast"], ["No such option", "--fast"]),
        (["run", PAIR, "--secure", "--backend", "inprocess"], ["--secure", "--backend processes"]),
        (["keys", "issue", "robot-x"], ["robot-I or robot-A-B", "'robot-x'"]),
        (["keys", "issue", "robot-3"], ["--keys keys", "no authority", "fes keys init"]),
        (["keys", "list", "--keys", "nowhere"], ["--keys nowhere", "fes keys init"]),
        (["keys", "init", "--days", "0"], ["--days", "0"]),
        (["view", "--keys", "nowhere"], ["--keys nowhere", "observer", "ca.crt"]),
        (["set", "channel.reference_snr=1", "--keys", "nowhere"], ["--keys nowhere", "operator", "ca.crt"]),
        (["walk"], ["No such command", "'walk'"]),
        (["view", "--run", "a b"], ["run's name", "'a b'"]),
    ],
)
def test_bad_input_is_reported_in_one_line_with_rule_and_value(
    words: list[str], said: list[str], tmp_path: Path
) -> None:
    line = complaint(call(tmp_path, "fes", *words), "fes")
    assert [word for word in said if word not in line] == []
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("program", "words", "said"),
    [
        ("fes-world", [], ["SCENARIO"]),
        ("fes-world", ["nowhere.toml"], ["nowhere.toml", "No such file"]),
        ("fes-world", [PAIR, "--set", "run.sed=1"], ["'run.sed'", "'run.seed'"]),
        ("fes-world", [PAIR, "--rtf", "-1"], ["--rtf", "'-1'"]),
        ("fes-world", [PAIR, "--cfg", "mode"], ["--cfg", "KEY:VALUE", "'mode'"]),
        ("fes-agent", [], ["--id"]),
        ("fes-agent", ["--id", "x"], ["--id", "A-B", "'x'"]),
        ("fes-agent", ["--id", "5-2"], ["--id", "A <= B", "'5-2'"]),
        ("fes-agent", ["--id", "-1"], ["--id", "'-1'"]),
        ("fes-agent", ["--id", "1", "--cfg", "mode"], ["--cfg", "KEY:VALUE", "'mode'"]),
        ("fes-agent", ["--id", "1", "--cfg", "no/such:1"], ["--cfg", "no/such:1"]),
        ("fes-world", [PAIR, "--keys", "nowhere"], ["--keys nowhere", "the world needs ca.crt"]),
        ("fes-agent", ["--id", "1-3", "--keys", "nowhere"], ["--keys nowhere", "the robot-1-3 needs ca.crt"]),
        ("fes-agent", ["--id", "1", "--run", "a/b"], ["run's name", "'a/b'"]),
        ("fes-robot", [], ["FILE"]),
        ("fes-robot", ["nowhere.toml"], ["nowhere.toml", "No such file"]),
        ("fes-robot", [ROBOT, "--id", "x"], ["--id", "'x'"]),
        ("fes-robot", [ROBOT, "--id", "0", "--keys", "nowhere"], ["--keys nowhere", "the robot-0 needs ca.crt"]),
        ("fes-tabletop", ["nowhere"], ["nowhere", "No such file"]),
    ],
)
def test_a_service_rejects_bad_input_in_one_line(
    program: str, words: list[str], said: list[str], tmp_path: Path
) -> None:
    line = complaint(call(tmp_path, program, *words), program)
    assert [word for word in said if word not in line] == []


def test_an_unanswered_agent_reports_the_world_and_time_it_waited_for(tmp_path: Path) -> None:
    endpoint = vacant()
    done = call(tmp_path, "fes-agent", "--id", "1", "--timeout", "1", "-e", endpoint)
    assert complaint(done, "fes-agent") == f"nothing listens on {endpoint} (tried for 1 s)"
    assert f"agent.1: waiting for the world at {endpoint}, run 'main'" in done.stderr


@pytest.mark.parametrize(
    "words",
    [
        ["fes-world", PAIR, "-l", "nonsense"],
        ["fes-agent", "--id", "1", "-e", "nonsense"],
        ["fes-agent", "--id", "1", "--timeout", "nan"],
    ],
)
def test_a_bad_endpoint_or_timeout_is_reported_in_one_line(words: list[str], tmp_path: Path) -> None:
    assert words[-1] in complaint(call(tmp_path, *words), words[0])


def test_a_closed_pipe_is_reported_without_a_file_name(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def broken() -> None:
        raise BrokenPipeError(32, "Broken pipe")

    monkeypatch.setattr(typer.main, "get_command", lambda app: lambda standalone_mode: broken())
    with pytest.raises(SystemExit) as left:
        cli.main()
    assert (left.value.code, capsys.readouterr().err) == (1, "fes: error: Broken pipe\n")


@pytest.mark.parametrize("words", [["fes"], ["fes", "keys"]], ids=" ".join)
def test_fes_without_a_command_shows_its_help(tmp_path: Path, words: list[str]) -> None:
    done = call(tmp_path, *words)
    output = (done.stdout + done.stderr).splitlines()
    assert done.returncode != 0
    assert [line for line in output if line.startswith(f"Usage: {' '.join(words)} ")]
    assert not [line for line in output if "error:" in line]
    assert len(output) > 5
