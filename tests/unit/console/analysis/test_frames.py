"""The numbers of an animation's frames are those of the run."""

import math
from dataclasses import replace

import numpy as np
import pytest

from console.analysis import frames, history, run_events
from console.analysis.frames import ABSENT, ALONE, CUTTING, TAKES_PART
from console.analysis.history import History
from fes.model import outage
from tests.support.loop import load


@pytest.fixture(scope="module")
def death() -> History:
    """Ten robots, the fifth of which leaves after 2 s and joins again after 4 s."""
    events = [{"at": 2.0, "kill": [4]}, {"at": 4.0, "restart": [4]}]
    return history.follow(load("neighborhood.toml", run__duration=6.0, event=events, expect=[]), "death")


@pytest.fixture(scope="module")
def team() -> History:
    """Ten robots that begin to take up a configuration."""
    return history.follow(load("team-paper-start.toml", run__duration=3.0, expect=[]), "team")


@pytest.mark.parametrize(
    ("duration", "length"), [(60.0, 12.0), (20.0, 4.0), (40.0, 8.0), (150.0, 15.0), (300.0, 15.0)]
)
@pytest.mark.parametrize("rate", [10.0, 20.0])
def test_a_minute_is_played_in_twelve_seconds_and_every_run_in_four_to_fifteen(
    duration: float, length: float, rate: float
) -> None:
    shown = frames.playback(round(duration / 0.02), 0.02, rate)
    assert shown.rate == rate
    assert len(shown.ticks) == length * rate
    assert (shown.ticks[0], shown.ticks[-1]) == (0, round(duration / 0.02) - 1)
    steps = np.diff(shown.ticks)
    assert steps.min() >= 1
    assert steps.max() - steps.min() <= 1  # at an even pace


def test_a_run_of_few_ticks_shows_each_of_them_once() -> None:
    assert frames.playback(1, 0.02, 10.0) == (np.array([0]), 0.25)
    shown = frames.playback(8, 0.02, 10.0)
    assert shown.ticks.tolist() == list(range(8))
    assert shown.rate == 2.0  # 4 s


def test_a_frame_has_the_poses_links_and_outage_of_its_tick(death: History) -> None:
    tick = 290
    shown = frames.frame(death, tick)
    assert shown.time == pytest.approx(5.8)
    assert np.array_equal(shown.poses, death.poses[tick])
    separations = np.hypot(*(shown.ends[:, 0] - shown.ends[:, 1]).T)
    lost = outage.outage_probability(separations, death.scenario.channel)
    # The outage is that of the last beacon, one tick old; no link is that close to a bound of the classes.
    expected = [0 if value < 0.15 else 1 if value < 0.35 else 2 for value in lost.tolist()]
    assert shown.outage.tolist() == expected
    np.testing.assert_allclose(death.outage[tick], lost, atol=0.01)


def test_a_robot_is_absent_alone_or_takes_part(death: History) -> None:
    assert set(frames.conditions(death, 0)) == {ALONE}  # no contact is open yet
    before, without, after = (frames.conditions(death, tick) for tick in (90, 190, 290))
    assert set(before) == set(after) == {TAKES_PART}
    assert np.flatnonzero(without == ABSENT).tolist() == [4]


def test_cutting_robots_are_marked_in_a_run_with_a_team_index_only(team: History, death: History) -> None:
    tick = 140
    assert CUTTING not in frames.conditions(death, tick)
    marked = set(np.flatnonzero(frames.conditions(team, tick) == CUTTING).tolist())
    links = team.links[tick]
    pairs = list(zip(links.rows.tolist(), links.peers.tolist(), strict=True))
    assert marked == {robot for robot in range(10) if not is_connected({*range(10)} - {robot}, pairs)}
    assert marked


def is_connected(robots: set[int], pairs: list[tuple[int, int]]) -> bool:
    reached = {min(robots)}
    while True:
        further = {b for a, b in pairs if a in reached and b in robots} - reached
        if not further:
            return reached == robots
        reached |= further


def test_a_path_ends_at_the_robot_and_begins_a_fixed_time_before(death: History) -> None:
    late, early = frames.paths(death, 299), frames.paths(death, 5)
    assert late.shape == early.shape == (10, frames.PATH_POINTS, 2)
    assert np.array_equal(late[:, -1], death.poses[299, :, :2])
    assert np.array_equal(late[:, 0], death.poses[round(299 * (1.0 - frames.PATH_SHARE)), :, :2])
    assert np.array_equal(early[:, 0], death.poses[0, :, :2])


def test_the_map_holds_all_positions_at_one_scale(death: History) -> None:
    for aspect in (0.5, 1.0, 3.0):
        west, east, south, north = frames.bounds(death, aspect)
        assert (east - west) / (north - south) == pytest.approx(aspect)
        x, y = death.poses[..., 0], death.poses[..., 1]
        assert west < x.min() < x.max() < east
        assert south < y.min() < y.max() < north
    lost = replace(death, poses=np.full_like(death.poses, math.inf))
    assert np.isfinite(frames.bounds(lost, 1.5)).all()


def test_the_axis_of_errors_spans_whole_decades() -> None:
    assert frames.error_range(np.array([0.2, 30.0]), np.array([math.nan, 5.0])) == pytest.approx((0.1, 100.0))
    assert frames.error_range(np.array([1e-9, 30.0])) == pytest.approx((1e-3, 100.0))
    assert frames.error_range(np.array([1e-9, 3e7])) == pytest.approx((100.0, 1e8))
    for none in (np.array([]), np.array([math.nan, math.inf]), np.zeros(3)):
        low, high = frames.error_range(none)
        assert 0.0 < low < high < math.inf


def test_the_mode_is_the_index_or_the_extension_in_its_place(death: History) -> None:
    assert frames.mode(death) == "index: oracle"
    for changes, mode in (
        ({"seeking": load("measured.toml").seeking}, "index: measured"),
        ({"seeking": load("swap.toml").seeking}, "law: fixed_separation"),
    ):
        assert frames.mode(replace(death, scenario=death.scenario.model_copy(update=changes))) == mode


def test_events_are_changes_of_the_channel_robots_and_hardware() -> None:
    events = [
        {"at": 0.2, "kill": [1]},
        {"at": 0.4, "set": {"channel.reference_snr": 5e6}},
        {"at": 0.6, "transmitter": {"robot": 2, "loss": 0.5}},
        {"at": 0.8, "restart": [1]},
        {"at": 90.0, "clock": {"robot": 0, "skew": 1.0}},
    ]
    run = history.follow(load("neighborhood.toml", run__duration=2.0, event=events, expect=[]))
    assert run.events == [
        run_events.Event(10, "robot 1 leaves"),
        run_events.Event(20, "channel: reference_snr"),
        run_events.Event(30, "transmitter of robot 2"),
        run_events.Event(40, "robot 1 joins"),
    ]
