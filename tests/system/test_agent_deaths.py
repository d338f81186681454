"""`fes run` survives the death of its agents: it names them and continues."""

import asyncio
import json
import os
import re
import signal
import subprocess
from pathlib import Path

import pytest

from tests.support import broken_laws
from tests.support.agent_runs import Run, under_way, warned
from tests.support.paths import CONFIGS
from tests.support.processes import PATIENCE, STARTING, children, fes, first_report, until

BROKEN = str(Path(broken_laws.__file__).resolve())


def test_dead_agents_do_not_end_a_run_and_the_summary_counts_them(tmp_path: Path) -> None:
    """By SIGKILL, as when memory is short, by SIGTERM, and by an error of its own."""
    with under_way(tmp_path, "paper.toml", "--json", "--duration", "8", "--rtf", "4") as run:
        run.kill("3")
        run.kill("4", how=signal.SIGTERM)
        run.kill("7", "8", how=signal.SIGSEGV)
        code, out, output = run.end()
    assert code == 0
    summary = json.loads(out)
    assert summary["ticks"] == 400
    gone = [re.search(rf"robot {robot} is absent from tick (\d+) on", run.log()) for robot in (3, 4, 7, 8)]
    absent = sum(400 - int(match[1]) for match in gone if match)
    assert summary["unscheduled_absences"] == absent > 0
    *deaths, last = output
    assert sorted(deaths) == [
        warned("robot 3", "was ended by SIGKILL"),
        warned("robot 4", "ended with exit code 0"),
        warned("robot 7", "was ended by SIGSEGV"),
        warned("robot 8", "was ended by SIGSEGV"),
    ]
    assert last == (
        f"fes: warning: unscheduled absences: {absent} robot-ticks; the digest is not that of an undisturbed run"
    )


@pytest.mark.parametrize(
    ("program", "log", "sign"),
    [(" -m agents --id 0 ", "world", "robot 0 is absent"), (" -m world ", "agent-0", "left after tick")],
    ids=["agent", "world"],
)
def test_a_process_frozen_for_longer_than_its_lease_is_counted_and_fails_an_expectation(
    tmp_path: Path, program: str, log: str, sign: str
) -> None:
    """Frozen as by a debugger, a container's pause or a busy machine, until its session has expired."""
    scenario = tmp_path / "frozen.toml"
    expected = '[[expect]]\nof = "unscheduled_absences"\nequals = 0\n'
    scenario.write_text((CONFIGS / "pair.toml").read_text() + "\n" + expected)
    with under_way(tmp_path, str(scenario), "--json", "--duration", "24", "--rtf", "4") as run:
        [pid] = [pid for pid, line in children(run.running.pid).items() if program in line]
        os.kill(pid, signal.SIGSTOP)
        until(lambda: sign in run.log(log))
        os.kill(pid, signal.SIGCONT)
        code, out, output = run.end()
    absent = json.loads(out)["unscheduled_absences"]
    assert code == 2
    assert absent > 0
    assert output[-1].startswith(
        f"fes: warning: unscheduled absences: {absent} robot-ticks; the digest is not that of"
    )


def test_with_respawn_a_dead_crew_is_restarted_with_all_of_its_robots(tmp_path: Path) -> None:
    words = ["--agents-per-process", "5", "--respawn", "--duration", "1000", "--rtf", "4"]
    with under_way(tmp_path, "paper.toml", *words) as run:
        first = run.pid("5-9")
        run.kill("5-9")
        until(lambda: "robot 9 is back from tick" in run.log())
        assert run.pid("5-9") != first
        assert all(f"robot {robot} is back from tick" in run.log() for robot in range(5, 10))
        assert "robot 0 is" not in run.log()
        run.running.send_signal(signal.SIGINT)
        code, _, output = run.end()
    assert code == 1  # it was interrupted
    why = "fes-agent --id 5-9 was ended by SIGKILL (its log: out/agent-5-9.log)"
    assert output[0] == f"fes: warning: robots 5-9: {why}; restarted in 0.5 s"
    assert output[1:] == ["fes: error: stopped by SIGINT; the results so far are in out"]


def test_an_agent_that_dies_before_the_run_begins_is_named_and_ends_it(tmp_path: Path) -> None:
    """The world waits for all robots before tick 0; one is delayed here, so that the run does not begin."""
    with under_way(tmp_path, "pair.toml", begun=False) as run:
        os.kill(run.pid("0"), signal.SIGSTOP)
        until(lambda: "waiting for the world" in run.log("agent-1"))
        run.kill("1")
        code, _, output = run.end()
    why = "fes-agent --id 1 was ended by SIGKILL (its log: out/agent-1.log)"
    assert (code, output) == (1, [f"fes: error: {why}; the run cannot begin without it"])


def test_a_run_without_an_agent_names_the_robot_it_waits_for(tmp_path: Path) -> None:
    with under_way(tmp_path, "pair.toml", "--duration", "1000", "--rtf", "1") as run:
        asyncio.run(first_report(run.out))
        run.kill("0", "1")
        assert run.running.stderr is not None
        output = [run.running.stderr.readline() for _ in range(4)]
        run.running.send_signal(signal.SIGINT)
        _, err = run.running.communicate(timeout=PATIENCE)
    assert output[0] == STARTING.format(2)
    assert sorted(output[1:3]) == [warned(f"robot {robot}", "was ended by SIGKILL") + "\n" for robot in "01"]
    endpoint = re.fullmatch(
        r"fes: warning: no agent is left: the world at (\S+) waits 60 s for one, and then ends\n", output[3]
    )
    assert endpoint
    assert endpoint[1].startswith("tcp/127.0.0.1:")
    assert err == "fes: error: stopped by SIGINT; the results so far are in out\n"


def test_a_world_whose_directory_was_removed_is_still_named(tmp_path: Path) -> None:
    with under_way(tmp_path, "pair.toml", "--duration", "4", "--rtf", "2") as run:
        subprocess.run(["rm", "-r", str(run.out)], check=True)
        code, _, output = run.end()
    assert code == 1
    unread = "its log cannot be read: No such file or directory: out/world.log"
    assert output == [f"fes: error: fes-world ended with exit code 1 ({unread})"]


def test_respawn_is_rejected_without_processes(tmp_path: Path) -> None:
    words = ["run", str(CONFIGS / "pair.toml"), "--backend", "inprocess", "--respawn"]
    done = subprocess.run(fes(*words), cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE)
    rule = "--respawn needs --backend processes: one loop has no processes of its own"
    assert (done.returncode, done.stderr) == (1, f"fes: error: {rule}\n")
    assert not list(tmp_path.iterdir())


def test_a_law_that_fails_in_every_robot_ends_the_run_at_once_with_its_line(tmp_path: Path) -> None:
    run = Run(tmp_path, "pair.toml", "--use", BROKEN, "--set", "formation.law=broken_laws:NotANumber")
    code, _, output = run.end()
    assert code == 1
    law = "formation law 'broken_laws:NotANumber': the pull must be finite, got nan"
    assert [line for line in output if law in line] == output
    assert output[-1].startswith("fes: error: ")
    assert output[-1].endswith("; no agent is left, and each ended with an error of its own")
    assert "waited" not in run.log()
