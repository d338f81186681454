"""Nothing that is stored of a run can be damaged in silence."""

from pathlib import Path

from tests import damage
from tests.damage import BEHIND, LINE, SAME
from tests.loop import load

CHANGES = 200


def test_no_damage_to_a_checkpoint_a_log_or_a_sweep_is_silent_or_a_traceback(tmp_path: Path) -> None:
    found = damage.damage(tmp_path, load("pair.toml", run__duration=1.0), CHANGES, seed=12)
    ends = {title: {kind for _, kind in counts} for title, counts in found.items()}
    assert {title: counts.total() for title, counts in found.items()} == dict.fromkeys(found, CHANGES)
    assert ends.pop("checkpoint/state") == ends.pop("checkpoint/trail") == ends.pop("a whole log") == {LINE}
    # What is cut from the end of a journal is gone, as after a loss of power. What stands in a log behind the
    # checkpoint is written anew.
    assert ends.pop("checkpoint/journal-2") == {LINE, SAME, BEHIND}
    assert found["checkpoint/journal-2"]["flip", LINE] + found["checkpoint/journal-2"]["zero", LINE] == 133
    assert LINE in ends["sweep.json"]
    assert set().union(*ends.values()) == {LINE, SAME}
