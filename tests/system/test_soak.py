"""Two minutes of the soak; docs/explanation/reliability.md has results of ten (`python -m tests.support.soak`)."""

from pathlib import Path

import pytest

from tests.support.soak import soak


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_a_team_outlives_two_minutes_of_kills_suspensions_and_world_restarts(tmp_path: Path) -> None:
    happened = soak(tmp_path / "run", 2.0, seed=4)
    assert happened["worlds killed"] + happened["worlds told to stop"] >= 3
    assert happened["worlds suspended"] >= 1
    assert happened["agents killed"] >= 3
    assert happened["agents suspended"] >= 3
