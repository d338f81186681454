"""What a run needs of this machine: Python, packages, files, a clock, a loopback interface."""

import contextlib
import re
import resource
import shutil
import socket
import sys
import tempfile
import time
from collections.abc import Iterator
from importlib import metadata
from pathlib import Path

from console.doctor.finding import Finding, failed, ok, warning
from console.keys import stale_keys
from fes.errors import reason
from fes.protocol.world_info import installed
from fes.system import distribution

OLDEST_PYTHON = (3, 11)

LEAST_FILES = 18
"""With fewer open files than this, besides those of its agent processes, no run starts [measured: 17]."""

FILES_PER_CHILD = 2 if sys.version_info >= (3, 12) else 1
"""Files that `fes run` has open for each agent process: from Python 3.12 on also a descriptor of the process."""

FILES_PER_ROBOT, FILES_OF_A_PROCESS = 2, 32
"""With so many for each agent process, and so many besides, there is room for certificates and for observers."""

USUAL_TEAM = 100
"""A team of this size should find enough open files."""

LITTLE_SPACE, NO_SPACE = 1 << 30, 10 << 20
"""Free bytes below which a long run may not end well, and below which no run can."""

DRIFT = 0.05
"""Realtime and monotonic clock may differ by this much over a moment [s]: beyond it, somebody sets the clock."""

MOMENT = 0.1
"""How long the clocks are watched [s]."""

YEAR_2024 = 1_704_067_200.0  # s since 1970

TOOLS = "dev"
"""The extra for developers, of no use to a run."""

_REQUIREMENT = re.compile(r"([A-Za-z0-9._-]+)(\[.*\])?\s*([^;]*)(?:;.*extra\s*==\s*['\"]([\w-]+)['\"])?")


def python() -> Finding:
    """The interpreter."""
    version = sys.version_info
    seen = f"{version.major}.{version.minor}.{version.micro} at {sys.executable}"
    if version < OLDEST_PYTHON:
        return failed("python", seen, f"install Python {OLDEST_PYTHON[0]}.{OLDEST_PYTHON[1]} or newer")
    return ok("python", seen)


def packages(requirements: list[str] | None = None) -> Iterator[Finding]:
    """What must be installed, each in a version that is new enough; then the extras, which nobody must have."""
    try:
        wanted = metadata.requires(distribution.NAME) or [] if requirements is None else requirements
    except metadata.PackageNotFoundError:
        yield failed("packages", "fes itself is not installed", distribution.install())
        return
    parsed = [found.groups() for found in map(_REQUIREMENT.match, wanted) if found]
    missing = [said for name, _, rule, extra in parsed if not extra and (said := lacks(name, rule))]
    if missing:
        yield failed("packages", "; ".join(missing), distribution.install())
    else:
        have = [f"{name} {installed(name)}" for name, _, _, extra in parsed if not extra]
        yield ok("packages", ", ".join(have))
    extras = sorted({str(extra) for *_, extra in parsed if extra} - {TOOLS})
    absent = [extra for extra in extras if any(own == extra and lacks(name, rule) for name, _, rule, own in parsed)]
    states = {"installed": [extra for extra in extras if extra not in absent], "not installed": absent}
    told = [f"{', '.join(named)}: {state}" for state, named in states.items() if named]
    if told:
        yield ok("extras", "; ".join(told))


def lacks(name: str, rule: str) -> str:
    """What is wrong with an installed package, or nothing.

    >>> lacks("numpy", ">=1.0"), lacks("no-such-package", ">=1")
    ('', 'no-such-package is missing')
    """
    have = installed(name)
    if have == "unknown":
        return f"{name} is missing"
    for least in re.findall(r">=\s*([\w.]+)", rule):
        if _numbers(have) < _numbers(least):
            return f"{name} {have} is older than {least}"
    return ""


def loopback() -> Finding:
    """Whether this machine can talk to itself, over a port of its own choice."""
    try:
        with (
            socket.create_server(("127.0.0.1", 0)) as server,
            socket.create_connection(server.getsockname(), timeout=2.0),
        ):
            return ok("loopback", "127.0.0.1 accepts connections")
    except OSError as error:
        return failed("loopback", f"127.0.0.1: {error}", "bring the loopback interface up: ip link set lo up")


def clock(moment: float = MOMENT) -> Finding:
    """Whether the clocks go, and go together."""
    real, steady = time.time(), time.monotonic()
    time.sleep(moment)
    passed, elapsed = time.time() - real, time.monotonic() - steady
    seen = f"{1e3 * elapsed:.1f} ms monotonic were {1e3 * passed:.1f} ms of the calendar"
    if elapsed <= 0.0:
        return failed("clock", seen, "the monotonic clock stands still: restart the machine")
    if real < YEAR_2024:
        return warning("clock", time.strftime("it says %Y-%m-%d", time.gmtime(real)), "set the date, or start NTP")
    if abs(passed - elapsed) > DRIFT:
        return warning("clock", seen, "somebody sets the clock while it runs: use one NTP client that slews")
    return ok("clock", seen)


def files(robots: int | None = None) -> Finding:
    """Whether `robots` agent processes, or a usual team, find enough open files."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if soft == resource.RLIM_INFINITY:
        return ok("open files", "no limit")
    team = robots or USUAL_TEAM
    needed = FILES_OF_A_PROCESS + FILES_PER_ROBOT * team
    room = max(0, soft - FILES_OF_A_PROCESS) // FILES_PER_ROBOT
    if needed <= soft:
        return ok("open files", f"{soft} a process: {room} robots with a process each")
    within = hard == resource.RLIM_INFINITY or hard >= needed
    remedy = (f"ulimit -n {needed}" if within else f"raise the hard limit of {hard}") + ", or --agents-per-process"
    least = LEAST_FILES + FILES_PER_CHILD * team
    seen = f"{soft} a process: {team} robots with a process each take {least}"
    if robots and soft < least:
        return failed("open files", seen, remedy)
    return warning("open files", f"{seen}, and {needed} with room to spare", remedy)


def directory(root: Path) -> Finding:
    """Whether run directories can be written, and how much room there is."""
    where = root if root.is_dir() else Path.cwd()
    free = None
    try:
        with tempfile.TemporaryFile(dir=where) as probe:
            probe.write(bytes(4096))
            probe.flush()
        with contextlib.suppress(OSError):
            free = shutil.disk_usage(where).free
    except OSError as error:
        said = f"{where.resolve()}: {reason(error, with_file=False)}"
        return failed("run directory", said, "stand where you may write, or give --out a folder where you may")
    if free is None:
        return ok("run directory", f"{where.resolve()} can be written")
    seen = f"{where.resolve()} can be written, {free / 1e9:.1f} GB free"
    if free < NO_SPACE:
        return failed("run directory", seen, "make room, or give --out a folder on another disk")
    if free < LITTLE_SPACE:
        return warning("run directory", seen, "make room before a long run, or give --out another disk")
    return ok("run directory", seen)


def private_keys(root: Path) -> Iterator[Finding]:
    """The private keys that killed runs have left in their run directories under `root`."""
    if left := stale_keys.found(root):
        where = " ".join(map(str, left))
        yield warning("private keys", f"left by runs that were killed: {where}", f"rm -r {where}")


def _numbers(version: str) -> tuple[int, ...]:
    """The numbers that a version begins with."""
    found = re.match(r"\d+(\.\d+)*", version)
    return tuple(int(part) for part in found[0].split(".")) if found else ()
