"""The process that writes a robot's log: the robot never waits for it, and survives its end."""

import os
import signal
from pathlib import Path

import pytest

from console.replay import robot_steps
from fes.errors import FesError
from fes.recording.robot_log import reader
from fes.recording.robot_log.layout import LOST
from fes.recording.robot_log.reader import RecordedEvent
from fes.recording.robot_log.recorder import RobotLog
from fes.recording.writer import connection
from fes.recording.writer.connection import LogWriter
from tests.support import robot_logs
from tests.support.processes import until

ROBOT = 1
MANY = 100_000  # steps: more than the pipe and the backlog hold


def writer_of(log: RobotLog) -> LogWriter:
    assert isinstance(log._log, LogWriter)
    return log._log


def test_a_log_of_its_own_process_is_that_of_a_log_in_this_process(tmp_path: Path) -> None:
    with RobotLog(tmp_path / "robot.mcap", robot_logs.header(ROBOT)) as log:
        robot_logs.add(log, robot_logs.steps(ROBOT))
    recording = reader.load(tmp_path / "robot.mcap")
    assert list(recording.steps()) == robot_logs.steps(ROBOT)
    assert recording.complaint is None
    assert robot_steps.rerun(recording) == 200


def test_a_robot_drops_steps_while_its_writer_stands_still_and_the_log_counts_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(connection, "BACKLOG", 1 << 16)
    warnings, path, steps = list[str](), tmp_path / "robot.mcap", robot_logs.steps(ROBOT)
    with RobotLog(path, robot_logs.header(ROBOT), warnings.append) as log:
        pid, made = writer_of(log).pid, 0
        os.kill(pid, signal.SIGSTOP)
        try:
            while log.lost < 10:
                assert made < MANY
                robot_logs.add(log, [steps[made % 200]._replace(tick=made)])
                made += 1
        finally:
            os.kill(pid, signal.SIGCONT)
        lost = log.lost

        def is_taken() -> bool:
            nonlocal made, lost
            robot_logs.add(log, [steps[made % 200]._replace(tick=made)])
            made += 1
            is_lost, lost = log.lost > lost, log.lost
            return not is_lost

        until(is_taken)
    recording = reader.load(path)
    gaps = [step.lost for step in recording.steps() if step.lost]
    assert gaps == [lost]
    assert recording.count == made
    events = [content for content in recording.contents() if isinstance(content, RecordedEvent)]
    assert [(event.kind, event.values) for event in events] == [(LOST, {"steps": lost, "events": 0})]
    assert warnings == [f"the process that writes {path} is behind: its log lacks steps"]


@pytest.mark.parametrize("how", ["killed", "full disk"])
def test_a_writer_that_ends_costs_one_warning_and_the_robot_continues(tmp_path: Path, how: str) -> None:
    warnings, path = list[str](), tmp_path / "robot.mcap" if how == "killed" else Path("/dev/full")
    log = RobotLog(path, robot_logs.header(ROBOT), warnings.append)
    if how == "killed":
        os.kill(writer_of(log).pid, signal.SIGKILL)

    def is_told() -> bool:
        robot_logs.add(log, robot_logs.steps(ROBOT)[:1])
        return bool(warnings)

    until(is_told)
    robot_logs.add(log, robot_logs.steps(ROBOT))
    log.event("gate", "held")
    log.finish()
    why = {
        "killed": f"cannot write {path}: the process that writes it was ended by SIGKILL",
        "full disk": "cannot write /dev/full: No space left on device",
    }[how]
    assert warnings == [f"{why}: the robot continues without a log"]
    assert log.lost >= len(robot_logs.steps(ROBOT))


def test_the_end_of_a_robot_waits_for_its_writer_only_as_long_as_it_may(tmp_path: Path) -> None:
    warnings, path = list[str](), tmp_path / "robot.mcap"
    log = RobotLog(path, robot_logs.header(ROBOT), warnings.append)
    robot_logs.add(log, robot_logs.steps(ROBOT))
    os.kill(writer_of(log).pid, signal.SIGSTOP)
    log.finish(patience=0.5)
    why = f"cannot write {path}: the process that writes it made no progress for 0.5 s"
    assert warnings == [f"{why}: the robot's log has no end"]
    assert not writer_of(log)._thread.is_alive()


def test_a_log_that_cannot_be_created_is_an_error_at_the_start(tmp_path: Path) -> None:
    with pytest.raises(FesError, match=r"robot\.mcap: No such file or directory$"):
        RobotLog(tmp_path / "none" / "robot.mcap", robot_logs.header(ROBOT))


def test_a_killed_robot_leaves_a_log_without_an_end(tmp_path: Path) -> None:
    path = tmp_path / "robot.mcap"
    log = RobotLog(path, robot_logs.header(ROBOT))
    robot_logs.add(log, robot_logs.steps(ROBOT))
    writer = writer_of(log)
    writer._wake.put(False)  # as at its death: the frames are in the pipe, which ends
    writer._thread.join()
    writer._process.wait()
    recording = reader.load(path)
    assert recording.complaint == (
        f"{path} has no end, its robot was killed or the file was cut: 200 steps are there"
    )
    assert robot_steps.rerun(recording) == 200
    writer._end()
