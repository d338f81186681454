"""Damage to any stored file of a run is detected."""

import shutil
from pathlib import Path
from random import Random

from tests.support import damage
from tests.support.commands import call, complaint
from tests.support.damage import BEHIND, LINE, SAME
from tests.support.loop import load

CHANGES = 200


def test_any_damage_to_a_checkpoint_a_log_or_a_sweep_is_reported_without_a_traceback(tmp_path: Path) -> None:
    outcomes = damage.damage(tmp_path, load("pair.toml", run__duration=1.0), CHANGES, seed=12)
    ends = {title: {kind for _, kind in counts} for title, counts in outcomes.items()}
    assert {title: counts.total() for title, counts in outcomes.items()} == dict.fromkeys(outcomes, CHANGES)
    assert ends.pop("checkpoint/state") == ends.pop("checkpoint/trail") == ends.pop("a whole log") == {LINE}
    # Notes cut from the end of a journal are lost, as after a power loss. The part of a log after the checkpoint is
    # written again.
    assert ends.pop("checkpoint/journal-2") == {LINE, SAME, BEHIND}
    assert outcomes["checkpoint/journal-2"]["flip", LINE] + outcomes["checkpoint/journal-2"]["zero", LINE] == 133
    assert LINE in ends["sweep.json"]
    assert set().union(*ends.values()) == {LINE, SAME}


def test_a_world_process_does_not_resume_a_damaged_run_and_leaves_its_files_alone(tmp_path: Path) -> None:
    run = damage.StoredRun(tmp_path, load("pair.toml", run__duration=0.4))
    for name in ("checkpoint/state", "checkpoint/trail", "checkpoint/journal-2", "run.mcap"):
        shutil.rmtree(run.work, ignore_errors=True)
        shutil.copytree(run.killed, run.work)
        content = (run.work / name).read_bytes()
        (run.work / name).write_bytes(damage.flip(Random(4), content[:500]) + content[500:])
        before = {path: path.read_bytes() for path in run.work.rglob("*") if path.is_file()}
        line = complaint(call(tmp_path, "fes-world", "--resume", "work", "-l", "tcp/127.0.0.1:0"), "fes-world")
        assert line.startswith(f"work/{name} is damaged")
        assert before == {path: path.read_bytes() for path in run.work.rglob("*") if path.is_file()}
