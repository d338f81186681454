"""Every key expression, in one table.

| key                             | payload                  | from -> to                          | rate         |
|---------------------------------|--------------------------|-------------------------------------|--------------|
| fes/<run>/world/alive           | liveliness token         | world -> all                        | while up     |
| fes/<run>/world/claim/<id>      | liveliness token         | world -> worlds                     | while up     |
| fes/<run>/robot/<i>/alive       | liveliness token         | agent i -> all                      | while up     |
| fes/<run>/world/welcome/<ids>   | Join, answered by Welcome | agent -> world -> agent            | once per join |
| fes/<run>/world/lease           | empty, answered by Lease | agent without an id -> world -> agent | once        |
| fes/<run>/world/about           | empty, answered by About | person -> world -> person           | when asked   |
| fes/<run>/robot/<i>/observation | Observation              | world -> agent i                    | each tick    |
| fes/<run>/robot/<i>/beacon      | Beacon                   | agent i -> peers in range           | each tick   |
| fes/<run>/robot/<i>/recall      | Recall, answered by Beacon | world -> agent i -> world         | if one was lost |
| fes/<run>/world/beacon/<i>/<ids> | Recall, answered by Beacon | agent ids -> world -> agent      | if one was lost |
| fes/<run>/robot/<i>/command     | Command                  | agent i -> world                    | each tick    |
| fes/<run>/world/report          | Report                   | world -> observers                  | 10 Hz (wall) |
| fes/<run>/world/set             | Change, answered by Effect | person -> world -> person         | when asked   |
| fes/<run>/robot/<i>/gate        | liveliness token         | gate of a real robot i -> all       | while up     |
| fes/<run>/robot/<i>/report      | RobotReport              | real robot i -> observers           | 10 Hz (wall) |
| fes/<run>/team/permit           | Permit                   | operator -> all gates               | 5 Hz (wall)  |
| fes/<run>/robot/<i>/start       | Start, answered by GateStatus | operator -> gate i -> operator | when asked   |
| fes/<run>/robot/<i>/stop        | empty, answered by GateStatus | operator -> gate i -> operator | when asked   |
| fes/<run>/robot/<i>/status      | empty, answered by GateStatus | person -> gate i -> person     | when asked   |

One robot owns one prefix, and an agent asks to join on a key that names its robots. So access rules are rules about
keys (`world/server/access.py`).
"""

import re
from collections.abc import Sequence
from functools import lru_cache

from fes.errors import FesError

DEFAULT_RUN = "main"
MAX_ROBOTS = 100_000
"""Largest number of robots in a run; ids are below it."""

LONGEST_KEY = 128
"""A robot's own key is shorter [characters]: the name of its run has at most 64."""

_RUN = re.compile(r"[A-Za-z0-9_.-]{1,64}")
_NUMBER = re.compile("[0-9]{1,9}")
_ROBOT = re.compile(r"fes/[^/]{1,64}/robot/(0|[1-9][0-9]{0,9})/[a-z]+")


def check_run(run: str) -> str:
    """`run` itself, if it can be part of a key; raises FesError."""
    if not _RUN.fullmatch(run):
        shown = run if len(run) <= 100 else f"{run[:100]}…"
        raise FesError(f"a run's name is 1 to 64 letters, digits, '_', '.' or '-', got '{shown}'")
    return run


def world_alive(run: str) -> str:
    """The world's liveliness token."""
    return f"fes/{run}/world/alive"


def claim(run: str, world: str) -> str:
    """The liveliness token of a world that wants to serve the run; each world has its own."""
    return f"fes/{run}/world/claim/{world}"


def world_tokens(run: str) -> str:
    """All liveliness tokens of worlds of a run."""
    return f"fes/{run}/world/**"


def about(run: str) -> str:
    """The key of queries for information about the world."""
    return f"fes/{run}/world/about"


def lease(run: str) -> str:
    """The key on which an agent without robots queries for one."""
    return f"fes/{run}/world/lease"


def tree(run: str) -> str:
    """A pattern of all keys of a run."""
    return f"fes/{run}/**"


def welcome(run: str, robots: str) -> str:
    """The key on which the agent of `robots`, as `span` writes them, asks to join; `*` for all agents."""
    return f"fes/{run}/world/welcome/{robots}"


def span(robots: Sequence[int]) -> str:
    """The robots of an agent in short, as in `--id`.

    >>> span([3]), span([0, 1, 2])
    ('3', '0-2')
    """
    first, last = min(robots), max(robots)
    return f"{first}" if first == last else f"{first}-{last}"


def parse_span(text: str, flag: str, forms: str = "I or A-B") -> tuple[int, ...]:
    """The robots in the value of `flag`, written in one of these `forms`; raises FesError.

    >>> parse_span("3", "--id"), parse_span("2-4", "--id")
    ((3,), (2, 3, 4))
    """
    first, dash, last = text.partition("-")
    if not _NUMBER.fullmatch(first) or (dash and not _NUMBER.fullmatch(last)):
        raise FesError(f"{flag} expects {forms} with integers from 0, got '{text[:40]}'")
    low, high = int(first), int(last) if dash else int(first)
    if high < low or high >= MAX_ROBOTS:
        raise FesError(f"{flag} expects I or A-B with A <= B < {MAX_ROBOTS}, got '{text}'")
    return tuple(range(low, high + 1))


def report(run: str) -> str:
    """The key of Reports to observers."""
    return f"fes/{run}/world/report"


def change(run: str) -> str:
    """The key of requests to change the channel."""
    return f"fes/{run}/world/set"


def robot_alive(run: str, robot: int | str) -> str:
    """A robot's liveliness token; `*` for all robots, as in the functions below."""
    return f"fes/{run}/robot/{robot}/alive"


def observation(run: str, robot: int | str) -> str:
    """The key of a robot's Observations."""
    return f"fes/{run}/robot/{robot}/observation"


def beacon(run: str, robot: int | str) -> str:
    """The key of a robot's Beacons."""
    return f"fes/{run}/robot/{robot}/beacon"


def recall(run: str, robot: int | str) -> str:
    """The key on which the world asks a robot to resend a beacon that the world did not get."""
    return f"fes/{run}/robot/{robot}/recall"


def held_beacon(run: str, robot: int | str, robots: str) -> str:
    """Key on which the agent of `robots`, as `span` writes them, asks for the world's copy of a robot's beacon."""
    return f"fes/{run}/world/beacon/{robot}/{robots}"


def command(run: str, robot: int | str) -> str:
    """The key of a robot's Commands."""
    return f"fes/{run}/robot/{robot}/command"


def gate_alive(run: str, robot: int | str) -> str:
    """The liveliness token of a real robot's gate; `*` for all robots, as in the functions below."""
    return f"fes/{run}/robot/{robot}/gate"


def robot_report(run: str, robot: int | str) -> str:
    """The key of a real robot's RobotReports."""
    return f"fes/{run}/robot/{robot}/report"


def permit(run: str) -> str:
    """The key of the operator's Permits, for the gates of all robots."""
    return f"fes/{run}/team/permit"


def gate_start(run: str, robot: int | str) -> str:
    """The key on which an operator asks a gate to let its robot move."""
    return f"fes/{run}/robot/{robot}/start"


def gate_stop(run: str, robot: int | str) -> str:
    """The key on which an operator asks a gate to stop its robot."""
    return f"fes/{run}/robot/{robot}/stop"


def gate_status(run: str, robot: int | str) -> str:
    """The key on which a person asks a gate for its state."""
    return f"fes/{run}/robot/{robot}/status"


def robot_of(key: str) -> int | None:
    """The robot that a key belongs to, or None if it is not a robot's own key (a wildcard, say).

    >>> robot_of("fes/main/robot/3/beacon"), robot_of("fes/main/robot/*/beacon")
    (3, None)
    """
    return _robot_of(key) if len(key) <= LONGEST_KEY else None


@lru_cache(maxsize=4096)
def _robot_of(key: str) -> int | None:
    match = _ROBOT.fullmatch(key)
    return int(match[1]) if match else None
