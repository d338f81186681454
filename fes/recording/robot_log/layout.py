"""Names and bounds of a robot's log, on which its writer and its reader agree."""

import re
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple, Self

from fes.extension import crew_laws
from fes.model.config import AgentConfig
from fes.recording.layout import ROBOT

ROBOT_LOG = 1
"""Number of the format: readers of another number cannot read it."""

KIND = "robot"
"""`kind` in the header: the log of a run has none."""

HEADER, STEPS, EVENTS = ROBOT, "/steps", "/events"
"""Topics that are read; the header is the first message."""

LOST = "lost"
"""Kind of the event that counts steps and events that are not in the log."""

MAX_EVENTS = 10_000
"""Most events between two steps."""

MAX_EVENT = 4096
"""Longest text, and longest JSON of the values, of an event [characters]."""

HEADER_SCHEMA = {
    "title": "fes.Robot",
    "type": "object",
    "description": "A robot, the settings that it received, and the programs that moved it",
    "required": ["kind", "format", "run", "robot", "boot", "config", "arithmetic", "extensions", "versions"],
    "properties": {
        "kind": {"const": KIND},
        "format": {"type": "integer", "description": "number of the format of the log"},
        "run": {"type": "string", "description": "name of the run"},
        "robot": {"type": "integer", "description": "id of the robot"},
        "boot": {"type": "string", "description": "drawn anew at each start of its program"},
        "config": {"type": "object", "description": "all settings that its code received"},
        "wall_ns": {"type": "integer", "description": "wall clock at the start [ns since 1970, UTC]"},
        "monotonic_ns": {"type": "integer", "description": "monotonic clock of its machine at that time"},
        "arithmetic": {
            "type": "object",
            "description": "fingerprint of the elementary functions, version of numpy, and the core in use",
        },
        "extensions": {"type": "array", "description": "kind, name and source of each extension, by its SHA-256"},
        "versions": {"type": "object", "description": "of fes, its libraries, Python and the machine"},
        "notes": {"type": "object", "description": "further settings of the robot, such as its scale"},
    },
}

EVENT_SCHEMA = {
    "title": "fes.RobotEvent",
    "type": "object",
    "description": "An event at a robot, other than its steps",
    "required": ["kind", "text", "monotonic_ns"],
    "properties": {
        "kind": {"type": "string"},
        "text": {"type": "string"},
        "monotonic_ns": {"type": "integer", "description": "monotonic clock of the robot's machine"},
        "tick": {"type": ["integer", "null"], "description": "tick of the latest step; null before the first"},
        "values": {"type": "object"},
    },
}

_NAME = re.compile(r"robot-(0|[1-9]\d{0,9})(?:-([1-9]\d{0,5}))?\.mcap")


class Fix(NamedTuple):
    """A pose as it arrived from the robot's body."""

    stamp_ns: int
    """Its own time stamp."""
    pose: tuple[float, float, float]
    """x, y, heading, with the units and the frame of its sender."""


class Header(NamedTuple):
    """A robot, at the start of its log."""

    run: str
    robot: int
    boot: str
    """Drawn anew at each start of its program."""
    config: AgentConfig
    wall_ns: int
    """Wall clock at the start [ns since 1970, UTC]."""
    monotonic_ns: int
    """Monotonic clock of its machine at that time."""
    extensions: list[dict[str, str]]
    """Evidence of each extension (`fes.extension.evidence`)."""
    notes: dict[str, Any]
    """Further settings of the robot, such as its scale; values of JSON."""

    @classmethod
    def now(cls, run: str, robot: int, boot: str, config: AgentConfig, **notes: Any) -> Self:
        """The header of a log that starts now; raises FesError for an extension that cannot be loaded."""
        extensions = [entry.table for entry in crew_laws.evidence_of(config)]
        return cls(run, robot, boot, config, time.time_ns(), time.monotonic_ns(), extensions, notes)


def new_path(folder: Path, robot: int) -> Path:
    """A file that does not exist: robot-3.mcap, or robot-3-2.mcap for the second start of the robot, and so on."""
    used = [start for number, start, _ in _listed(folder.iterdir()) if number == robot]
    start = max(used, default=0) + 1
    return folder / (f"robot-{robot}.mcap" if start == 1 else f"robot-{robot}-{start}.mcap")


def paths(folder: Path, robot: int | None = None) -> list[Path]:
    """The logs of robots in a folder, or those of one robot, by robot and start.

    >>> [path.name for _, _, path in _listed([Path("robot-10.mcap"), Path("robot-2-2.mcap"), Path("robot-2.mcap")])]
    ['robot-2.mcap', 'robot-2-2.mcap', 'robot-10.mcap']
    """
    return [path for number, _, path in _listed(folder.iterdir()) if robot in (None, number)]


def counted(number: int, what: str = "step") -> str:
    """A number of steps or events, in words.

    >>> counted(1), counted(2, "event")
    ('1 step', '2 events')
    """
    return f"{number:,} {what}{'' if number == 1 else 's'}"


def _listed(files: Iterable[Path]) -> list[tuple[int, int, Path]]:
    """Robot, start and file of each log of a robot among files, in order."""
    matches = [(match, path) for path in files if (match := _NAME.fullmatch(path.name))]
    return sorted((int(match[1]), int(match[2] or 1), path) for match, path in matches)
