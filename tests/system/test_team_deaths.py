"""A team that takes up a configuration loses the process of an agent: the others take up the patch of as many."""

import json
from pathlib import Path

from console.replay import command as replay_command
from console.replay import log
from tests.support.agent_runs import under_way, warned


def test_a_team_takes_up_the_patch_of_the_others_when_an_agent_is_killed(tmp_path: Path) -> None:
    words = ["--agents-per-process", "3", "--duration", "28", "--json"]
    with under_way(tmp_path, "team-paper-start.toml", *words) as run:
        run.kill("9")
        _, out, output = run.end()
    summary = json.loads(out)
    assert output[0] == warned("robot 9", "was ended by SIGKILL")
    assert summary["unscheduled_absences"] > 0
    assert summary["disk_connected_always"]
    # of nine robots: the target of ten is .689
    assert abs(summary["team_index_target"] - 0.6979) < 1e-4
    assert summary["team_index"] > 0.99 * summary["team_index_target"]
    assert summary["cutting_robots"] == 0
    assert len(summary["edges"]) == 16
    recorded = log.load(run.out / "run.mcap")
    assert replay_command.rerun(recorded, all_robots=True)["digest"] == summary["digest"]
