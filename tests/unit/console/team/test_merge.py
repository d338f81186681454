"""Reports of three real robots, merged into one."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from console.team.merge import SILENT, Team
from fes.protocol.messages import Command
from fes.protocol.report import Report, decode_report, encode_report
from fes.protocol.robot_report import MAX_TIME, NO_AGE, RobotReport
from tests.support.examples import EXAMPLES
from tests.support.fake_robots import a_robot_report, heard
from tests.support.payloads import bits, robot_reports

LINKS = {0: [1], 1: [0, 2], 2: [1]}


def command(robot: int, estimates: dict[int, float], learnt: list[float] | None = None, tick: int = 500) -> Command:
    """A Command with an estimate of each linked peer [m]."""
    ids = np.array(sorted(estimates), dtype=np.int64)
    values = np.array([estimates[peer] for peer in sorted(estimates)])
    return Command(tick, robot, (1.0, 0.0), ids, values, np.array(learnt or []))


def a_team(now: float = 100.0, without: int | None = None, **fields: Any) -> Team:
    """Three robots in a row, 60 m and 80 m apart, whose reports arrived at `now`."""
    team, x = Team("field"), {0: 0.0, 1: 60.0, 2: 140.0}
    for robot, peers in LINKS.items():
        if robot != without:
            team.add(a_robot_report(robot, peers, pose=(x[robot], 0.0, 0.5), **fields), now)
    return team


def link(report: Report, name: str) -> list[float]:
    values: list[float] = getattr(report, name).tolist()
    return values


def test_links_and_separations_come_from_the_poses_of_the_robots_themselves() -> None:
    report = a_team().report(100.0)
    assert (report.a.tolist(), report.b.tolist()) == ([0, 1], [1, 2])
    assert link(report, "separation") == [60.0, 80.0]
    assert report.poses.tolist() == [[0.0, 0.0, 0.5], [60.0, 0.0, 0.5], [140.0, 0.0, 0.5]]
    assert report.alive.tolist() == [1, 1, 1]


def test_each_end_of_a_link_has_its_own_estimate_and_their_differences_add_up() -> None:
    team = Team("field")
    for robot, estimates in ((0, {1: 61.0}), (1, {0: 64.0, 2: 70.0}), (2, {1: 69.0})):
        team.add(a_robot_report(robot, LINKS[robot], command=command(robot, estimates)), 5.0)
    report = team.report(5.0)
    assert (link(report, "estimate_ab"), link(report, "estimate_ba")) == ([61.0, 70.0], [64.0, 69.0])
    assert report.disagreement == 4.0


def test_beacons_of_both_ends_are_counted_without_concealed_ticks() -> None:
    team = Team("field")
    team.add(a_robot_report(0, [1], beacons=heard([1], 80, 15, 5)), 5.0)
    team.add(a_robot_report(1, [0], beacons=heard([0], 70, 30, 0)), 5.0)
    report = team.report(5.0)
    assert (link(report, "sent"), link(report, "decoded")) == ([195.0], [150.0])
    assert (report.beacons_sent, report.beacons_decoded) == (200, 150)
    assert team.totals() == {"heard": 150, "missed": 45, "concealed": 5}


def test_no_number_that_needs_the_truth_exists() -> None:
    report = a_team().report(100.0)
    assert report.is_of_robots
    names = ("optimal_separation", "true_level", "true_exponent", "estimate_error_max", "separation_error_max")
    assert all(math.isnan(getattr(report, name)) for name in (*names, "mean_estimate_error", "tracking_time"))
    assert np.isnan(report.outage).all()


def test_a_silent_robot_is_dead_keeps_its_pose_and_its_estimate_as_its_peer_heard_it() -> None:
    team = a_team(without=0)
    team.add(a_robot_report(0, [1], pose=(0.0, 0.0, 0.5)), 100.0 - SILENT)
    report = team.report(100.0)
    assert report.alive.tolist() == [0, 1, 1]
    assert report.poses[0].tolist() == [0.0, 0.0, 0.5]
    assert (report.a.tolist(), report.b.tolist()) == ([0, 1], [1, 2])  # robot 1 still uses the link
    team.members[1].report.beacons.estimates[:] = 66.0
    assert link(team.report(100.0), "estimate_ab")[0] == 66.0


def test_a_team_of_silent_robots_has_no_links() -> None:
    report = a_team().report(100.0 + SILENT)
    assert (report.alive.tolist(), report.a.tolist()) == ([0, 0, 0], [])
    assert a_team().modes(100.0 + SILENT) == ""


def test_ids_may_have_gaps_and_a_robot_that_was_never_seen_has_no_pose() -> None:
    team = a_team(without=1)
    assert np.isnan(team.report(100.0).poses[1]).all()
    team.expect(5)
    report = team.report(100.0)
    assert report.alive.tolist() == [1, 0, 1, 0, 0, 0]
    assert Team("field", range(3, 8)).number == 8


def test_a_robot_without_a_first_pose_is_alive_and_its_separations_are_unknown() -> None:
    report = a_team(pose_age=NO_AGE).report(100.0)
    assert report.alive.tolist() == [1, 1, 1]
    assert np.isnan(report.poses).all()
    assert np.isnan(report.separation).all()


@pytest.mark.parametrize(
    ("boot", "time", "is_new"), [(7, 10.0, False), (7, 9.0, False), (7, 10.1, True), (8, 0.1, True)]
)
def test_an_old_or_repeated_report_is_dropped_unless_the_agent_has_restarted(
    boot: int, time: float, is_new: bool
) -> None:
    team = a_team()
    assert team.add(a_robot_report(0, [1], time, boot=boot), 100.5) == is_new
    assert team.members[0].starts == (2 if boot == 8 else 1)


def test_counts_of_an_earlier_start_remain_in_the_totals() -> None:
    team = Team("field")
    team.add(a_robot_report(0, [1], beacons=heard([1], 80, 15, 5)), 5.0)
    team.add(a_robot_report(0, [1], 0.1, boot=8, beacons=heard([1], 3, 1, 0)), 6.0)
    assert team.totals() == {"heard": 83, "missed": 16, "concealed": 5}


def test_time_is_that_of_the_robot_that_has_run_longest_and_never_goes_back() -> None:
    team = Team("field")
    team.add(a_robot_report(0, [], 3.0), 100.0)
    assert team.report(100.0).elapsed == 3.0
    team.add(a_robot_report(1, [], 50.0), 100.1)
    assert team.report(100.1).elapsed == pytest.approx(50.0)
    team.add(a_robot_report(1, [], 0.0, boot=8), 101.1)  # its agent has restarted
    assert team.report(101.1).elapsed == pytest.approx(51.0)
    assert team.report(101.1).tick == round(51.0 / 0.02)


def test_the_graph_of_robots_that_hear_each_other_is_connected_only_while_beacons_arrive() -> None:
    team = Team("field")
    for robot, peers in LINKS.items():
        team.add(a_robot_report(robot, peers), 100.0)
    assert team.report(100.0).disk_connected
    for now in (101.0, 102.0, 103.0):  # robot 2 hears no new beacon, and robot 1 none of robot 2
        for robot, count in ((0, 90 + round(now)), (1, 90), (2, 90)):
            report = a_robot_report(robot, LINKS[robot], now - 80.0, beacons=heard(LINKS[robot], count))
            team.add(report, now)
    assert not team.report(103.0).disk_connected


def test_the_level_that_both_ends_have_learnt_is_averaged_and_gives_the_reception_at_the_separation() -> None:
    team = Team("field")
    for robot, level in ((0, -2.0), (1, -1.0)):
        last = command(robot, {1 - robot: 68.0}, [level, 3.0])
        pose = (75.0 * robot, 0.0, 0.0)
        team.add(a_robot_report(robot, [1 - robot], pose=pose, command=last, reference_separation=75.0), 5.0)
    report = team.report(5.0)
    assert (link(report, "learnt_level"), link(report, "learnt_exponent")) == ([-1.5], [3.0])
    assert link(report, "learnt_reception") == pytest.approx([math.exp(-math.exp(-1.5))])


def test_a_law_that_learns_other_numbers_has_no_reception() -> None:
    team = Team("field")
    team.add(a_robot_report(0, [1], command=command(0, {1: 68.0}, [1.0, 2.0])), 5.0)
    team.add(a_robot_report(1, [0], command=command(1, {0: 68.0}, [1.0]), reference_separation=75.0), 5.0)
    assert np.isnan(team.report(5.0).learnt_reception).all()


def test_modes_are_counted_and_a_robot_without_a_gate_is_named() -> None:
    team = a_team()
    team.add(a_robot_report(2, [1], 11.0, mode=""), 100.0)
    assert team.modes(100.0) == "2 running, 1 without a gate"


@settings(max_examples=EXAMPLES // 3)
@given(reports=st.lists(st.tuples(robot_reports(), st.integers(0, 4), st.floats(0.0, 5.0)), min_size=1, max_size=4))
def test_any_reports_merge_into_a_report_that_can_be_sent(reports: list[tuple[RobotReport, int, float]]) -> None:
    team, now = Team("field"), MAX_TIME
    for report, robot, later in reports:
        now += later
        team.add(report._replace(command=report.command._replace(robot=robot)), now)
    merged = team.report(now)
    assert bits(decode_report(encode_report(merged))) == bits(merged)
    assert not np.isinf(merged.poses).any()
