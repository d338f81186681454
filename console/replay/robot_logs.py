"""The command fes replay for logs of real robots: one file, or a folder with the files of several."""

from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

from console.replay import robot_steps
from console.terminal import counting, printing, progress
from console.terminal.counting import Watch
from console.terminal.progress import Bar
from fes import process
from fes.errors import FesError, Stopped
from fes.recording import reader as run_reader
from fes.recording.layout import AT_ITS_END
from fes.recording.robot_log import layout, reader
from fes.recording.robot_log.reader import RobotRecording
from fes.system import strict_json


def chosen(target: Path, robot: int | None, all_: bool) -> list[Path]:
    """The logs of robots that a command means by `target`; none if it is a run, or a run's log.

    Raises FesError in one line, also for a robot that the target does not have.
    """
    if not target.is_dir():
        is_of_robot = target.is_file() and reader.is_robot_log(target)
        if is_of_robot and all_:
            raise FesError(f"--all: {target} is the log of one robot")
        return [target] if is_of_robot else []
    every = layout.paths(target)
    if all_ or not every:
        return every
    paths = every if robot is None else layout.paths(target, robot)
    if run_reader.find(target) is not None and (robot is None or not paths):
        return []  # beside the robots' logs lies the one that their operator recorded
    if not paths:
        raise FesError(f"--robot {robot}: {target} has no robot-{robot}.mcap")
    if robot is None and len(paths) > 1:
        raise FesError(f"{target} holds {len(paths)} logs of robots: give --robot I or --all")
    return paths


def refuse(target: Path) -> None:
    """Raise FesError for a target with logs of robots and none of a run, which a page cannot show."""
    if target.is_dir():
        is_of_robots = bool(layout.paths(target)) and run_reader.find(target) is None
    else:
        is_of_robots = target.is_file() and reader.is_robot_log(target)
    if is_of_robots:
        raise FesError(f"--web shows the log of a run, not that of a robot: {target}")


def replay(paths: list[Path], robot: int | None, json_: bool) -> int:
    """Execute the robots of these logs again, and print one line each; returns the exit code.

    With one log, raises FesError where it differs or lacks steps. With several, each fault is its line.
    """
    if len(paths) == 1:
        log = reader.load(paths[0])
        if robot not in (None, log.header.robot):
            raise FesError(f"--robot {robot}: {log.path} is the log of robot {log.header.robot}")
        with _shown(paths) as bar:
            result = _rerun(log, bar)
        printing.line(strict_json.dumps(result) if json_ else _line(result))
        if log.end is not None:
            write = process.tell if json_ else printing.line
            write(f"the robot ended early: {log.end}")
        if log.complaint is not None:
            raise FesError(log.complaint)
        return process.SUCCESS
    results = []
    with _shown(paths) as bar:
        watches = counting.parts(bar, *map(_length, paths))
        for number, (path, watch) in enumerate(zip(paths, watches, strict=True)):
            bar.note(f"{number}/{len(paths)} robots")
            results.append(_attempt(path, watch))
    for line in [strict_json.dumps(results)] if json_ else map(_line, results):
        printing.line(line)
    return process.FAILURE if any("error" in result for result in results) else process.SUCCESS


def _attempt(path: Path, watch: Watch) -> dict[str, Any]:
    """The result for one of several logs, or its fault."""
    try:
        log = reader.load(path)
        result = _rerun(log, watch)
        if log.complaint is not None:
            raise FesError(log.complaint)
    except Stopped:
        raise
    except FesError as error:
        text = str(error)
        return {"log": path.name, "error": text if text.startswith(str(path)) else f"{path}: {text}"}
    return {"log": path.name, **result, "ended": log.ended}


def _rerun(log: RobotRecording, watch: Watch) -> dict[str, Any]:
    return {"robot": log.header.robot, "ticks": robot_steps.rerun(log, watch)}


def _shown(paths: list[Path]) -> AbstractContextManager[Bar]:
    """A bar for the steps of all logs."""
    return progress.shown("replaying", sum(map(_length, paths)))


def _length(path: Path) -> int:
    """Number of steps in a log as far as it is known: 0 for one without an end, or that cannot be read."""
    try:
        return reader.load(path).count or 0
    except FesError:
        return 0


def _line(result: dict[str, Any]) -> str:
    if "error" in result:
        return str(result["error"])
    early = result.get("ended", AT_ITS_END)
    end = "" if early == AT_ITS_END else f"; it ended early: {early}"
    return f"robot {result['robot']}, executed again: {result['ticks']} ticks, the same to the bit{end}"
