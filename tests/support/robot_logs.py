"""Logs of a robot for tests: its inputs are those of a run in one loop.

`python -m tests.support.robot_logs FILE` writes the stored log of the present format.
"""

import sys
from collections.abc import Callable, Iterable
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from agents.runtime.hosted_crew import HostedCrew
from console.replay import log as run_logs
from fes.model.config import AgentConfig
from fes.model.sensing import DECODED
from fes.protocol import messages
from fes.protocol.messages import Welcome
from fes.recording import records
from fes.recording.layout import AT_ITS_END
from fes.recording.messages_pb2 import RobotStep
from fes.recording.robot_log.layout import Fix, Header
from fes.recording.robot_log.reader import RecordedStep
from fes.recording.robot_log.recorder import RobotLog
from fes.recording.writer.frames import STEP
from fes.recording.writer.log_file import LogFile
from tests.support import recordings
from tests.support.loop import load
from tests.support.recordings import Edit
from world.config.scenario import Scenario, agent_config

START = 1_700_000_000_000_000_000  # ns since 1970
TICK = 20_000_000  # ns
POSES = [[0.0, 0.0, 0.5], [60.0, 0.0, 2.0], [30.0, 50.0, 1.0]]


def scenario(**overrides: Any) -> Scenario:
    """Three robots that measure the channel."""
    return load("measured.toml", robots__poses=POSES, **overrides)


def header(robot: int, config: AgentConfig | None = None, **notes: Any) -> Header:
    """A header with fixed times."""
    settings = agent_config(scenario()) if config is None else config
    return Header("field", robot, "a1b2", settings, START, 5 * TICK, [], notes)


@cache
def steps(robot: int, duration: float = 4.0) -> list[RecordedStep]:
    """The steps of one of three robots in a run, with the Beacons that decoded at it."""
    result = list[RecordedStep]()
    with TemporaryDirectory() as folder:
        path = Path(folder) / "run.mcap"
        recordings.record(path, scenario(run__duration=duration))
        before = list[bytes]()
        for tick in run_logs.load(path).ticks():
            sensed = messages.decode_observation(tick.payloads.observations[robot])
            codes = zip(sensed.in_range.tolist(), sensed.reception.tolist(), strict=True)
            heard = [before[peer] for peer, code in codes if code == DECODED and before]
            own = (
                tick.payloads.observations[robot],
                heard,
                tick.payloads.beacons[robot],
                tick.payloads.commands[robot],
            )
            fix = Fix(tick.number * TICK, sensed.pose)
            result.append(RecordedStep(tick.number, 0, tick.number, (5 + tick.number) * TICK, *own, fix))
            before = tick.payloads.beacons
    return result


def executed(inputs: Iterable[RecordedStep], robot: int, config: AgentConfig | None = None) -> list[RecordedStep]:
    """The steps of a robot that receives the inputs of other steps; an agent's code computes what it returns."""
    settings = agent_config(scenario()) if config is None else config
    crew, result = HostedCrew(Welcome((robot,), settings)), list[RecordedStep]()
    for number, step in enumerate(inputs):
        observations = crew.observe([messages.decode_observation(step.observation)])
        [(_, beacon, command)] = crew.answer(observations, [messages.decode_beacon(one) for one in step.beacons])
        result.append(step._replace(number=number, beacon=beacon, command=command))
    return result


def add(log: RobotLog, recorded: Iterable[RecordedStep]) -> None:
    """Add steps to a log."""
    for step in recorded:
        log.tick(step.tick, step.observation, step.beacons, step.beacon, step.command, step.monotonic_ns, step.fix)


def write(
    path: Path,
    robot: int,
    recorded: Iterable[RecordedStep] | None = None,
    reason: str = AT_ITS_END,
    writer: Callable[[Path], LogFile] = LogFile,
) -> Path:
    """A complete log of a robot, written in this process; returns its path."""
    log = RobotLog(path, header(robot, scale=0.01), writer=writer, warn=lambda text: None, clock=lambda: 5 * TICK)
    log.event("gate", "the gate is open", permit=1)
    add(log, steps(robot) if recorded is None else recorded)
    log.finish(reason)
    return path


class Busy(LogFile):
    """A writer that is behind while the robot makes some of its steps."""

    def __init__(self, path: Path, steps: Iterable[int]) -> None:
        super().__init__(path)
        self._steps = set(steps)

    def offer(self, tick: int, time: int, messages: list[Any]) -> bool:
        """Add messages, unless this writer is behind."""
        is_behind = messages[-1][0] == STEP and tick in self._steps
        return not is_behind and super().offer(tick, time, messages)


def edited(tick: int, change: Callable[[RobotStep], None]) -> Edit:
    """An edit of the step of one tick, for `recordings.rewrite`."""

    def edit(topic: str, at: int, message: bytes) -> bytes:
        if topic != "/steps" or at != tick:
            return message
        step = RobotStep.FromString(message)
        change(step)
        return bytes(step.SerializeToString())

    return edit


def cut(path: Path, to: Path) -> Path:
    """The file without its end, as a killed robot leaves it: all whole chunks remain."""
    ends = [block.place for block in records.Reader(path)]
    to.write_bytes(path.read_bytes()[: ends[-1]])  # the last block is the metadata
    return to


if __name__ == "__main__":
    write(Path(sys.argv[1]), 1, steps(1)[:50])
