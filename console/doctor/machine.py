"""Checks of this machine: Python, packages, arithmetic, open files, clock, loopback interface, disk."""

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
from fes.system import distribution, fingerprint

OLDEST_PYTHON = (3, 11)

LEAST_FILES = 18
"""Fewest open files with which a run starts, without those for its agent processes; measured: 17 are too few."""

FILES_PER_CHILD = 2 if sys.version_info >= (3, 12) else 1
"""Files that `fes run` has open per agent process; from Python 3.12 on also a descriptor of the process."""

FILES_PER_ROBOT, FILES_OF_A_PROCESS = 2, 32
"""Open files per agent process, and for all else, which also suffice for certificates and observers."""

USUAL_TEAM = 100
"""Number of robots for which open files should suffice, unless a run reports its own number."""

LITTLE_SPACE, NO_SPACE = 1 << 30, 10 << 20
"""Free space below which a long run may fail, and below which every run fails [bytes]."""

DRIFT = 0.05
"""Largest difference between the realtime and the monotonic clock over MOMENT [s], unless the clock is being set."""

MOMENT = 0.1
"""Duration of the comparison of the clocks [s]."""

YEAR_2024 = 1_704_067_200.0  # s since 1970

TOOLS = "dev"
"""The extra for developers, which no run needs."""

_REQUIREMENT = re.compile(r"([A-Za-z0-9._-]+)(\[.*\])?\s*([^;]*)(?:;.*extra\s*==\s*['\"]([\w-]+)['\"])?")


def python() -> Finding:
    """The version of Python."""
    version = sys.version_info
    seen = f"{version.major}.{version.minor}.{version.micro} at {sys.executable}"
    if version < OLDEST_PYTHON:
        return failed("python", seen, f"install Python {OLDEST_PYTHON[0]}.{OLDEST_PYTHON[1]} or newer")
    return ok("python", seen)


def packages(requirements: list[str] | None = None) -> Iterator[Finding]:
    """The required packages and their versions, then the extras, which are optional."""
    try:
        wanted = metadata.requires(distribution.NAME) or [] if requirements is None else requirements
    except metadata.PackageNotFoundError:
        yield failed("packages", "fes itself is not installed", distribution.install())
        return
    parsed = [match.groups() for match in map(_REQUIREMENT.match, wanted) if match]
    missing = [problem for name, _, rule, extra in parsed if not extra and (problem := lacks(name, rule))]
    if missing:
        yield failed("packages", "; ".join(missing), distribution.install())
    else:
        versions = [f"{name} {installed(name)}" for name, _, _, extra in parsed if not extra]
        yield ok("packages", ", ".join(versions))
    extras = sorted({str(extra) for *_, extra in parsed if extra} - {TOOLS})
    absent = [extra for extra in extras if any(own == extra and lacks(name, rule) for name, _, rule, own in parsed)]
    states = {"installed": [extra for extra in extras if extra not in absent], "not installed": absent}
    parts = [f"{', '.join(members)}: {state}" for state, members in states.items() if members]
    if parts:
        yield ok("extras", "; ".join(parts))


def lacks(name: str, rule: str) -> str:
    """The problem with an installed package, in one line; empty without one.

    >>> lacks("numpy", ">=1.0"), lacks("no-such-package", ">=1")
    ('', 'no-such-package is missing')
    """
    version = installed(name)
    if version == "unknown":
        return f"{name} is missing"
    for least in re.findall(r">=\s*([\w.]+)", rule):
        if _numbers(version) < _numbers(least):
            return f"{name} {version} is older than {least}"
    return ""


def arithmetic() -> Finding:
    """The fingerprint of the arithmetic, compared with that of every other machine."""
    own = fingerprint.table()
    seen = f"fingerprint {own['fingerprint']}, with numpy {own['numpy']}"
    if own["fingerprint"] == fingerprint.EXPECTED:
        return ok("arithmetic", f"{seen}: the same digits as on every other machine")
    problem = f"{seen}: this machine's digits differ from every other's, whose fingerprint is {fingerprint.EXPECTED}"
    return warning(
        "arithmetic", problem, "use a 64-bit Python, and load no library that was compiled with -ffast-math"
    )


def loopback() -> Finding:
    """Connections within this machine, at a free port."""
    try:
        with (
            socket.create_server(("127.0.0.1", 0)) as server,
            socket.create_connection(server.getsockname(), timeout=2.0),
        ):
            return ok("loopback", "127.0.0.1 accepts connections")
    except OSError as error:
        return failed("loopback", f"127.0.0.1: {error}", "bring the loopback interface up: ip link set lo up")


def clock(moment: float = MOMENT) -> Finding:
    """The realtime and the monotonic clock: both must advance, at the same rate."""
    real, steady = time.time(), time.monotonic()
    time.sleep(moment)
    passed, elapsed = time.time() - real, time.monotonic() - steady
    seen = f"{1e3 * elapsed:.1f} ms of the monotonic clock were {1e3 * passed:.1f} ms of the realtime clock"
    if elapsed <= 0.0:
        return failed("clock", seen, "the monotonic clock stands still: restart the machine")
    if real < YEAR_2024:
        return warning(
            "clock", time.strftime("the date is %Y-%m-%d", time.gmtime(real)), "set the date, or start NTP"
        )
    if abs(passed - elapsed) > DRIFT:
        return warning("clock", seen, "the clock is being set: use a single NTP client, which slews")
    return ok("clock", seen)


def files(robots: int | None = None) -> Finding:
    """The limit on open files, compared with the need of `robots` agent processes, or of USUAL_TEAM."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if soft == resource.RLIM_INFINITY:
        return ok("open files", "no limit")
    team = robots or USUAL_TEAM
    needed = FILES_OF_A_PROCESS + FILES_PER_ROBOT * team
    room = max(0, soft - FILES_OF_A_PROCESS) // FILES_PER_ROBOT
    if needed <= soft:
        return ok("open files", f"{soft} per process: enough for {room} robots with a process each")
    within = hard == resource.RLIM_INFINITY or hard >= needed
    remedy = (f"ulimit -n {needed}" if within else f"raise the hard limit of {hard}") + ", or --agents-per-process"
    least = LEAST_FILES + FILES_PER_CHILD * team
    seen = f"{soft} per process: {team} robots with a process each take {least}"
    if robots and soft < least:
        return failed("open files", seen, remedy)
    return warning("open files", f"{seen}, and {needed} with room to spare", remedy)


def directory(root: Path) -> Finding:
    """The folder of run directories: writable, with enough free space."""
    folder = root if root.is_dir() else Path.cwd()
    free = None
    try:
        with tempfile.TemporaryFile(dir=folder) as probe:
            probe.write(bytes(4096))
            probe.flush()
        with contextlib.suppress(OSError):
            free = shutil.disk_usage(folder).free
    except OSError as error:
        problem = f"{folder.resolve()}: {reason(error, with_file=False)}"
        return failed("run directory", problem, "change to a writable folder, or name one with --out")
    if free is None:
        return ok("run directory", f"{folder.resolve()} can be written")
    seen = f"{folder.resolve()} can be written, {free / 1e9:.1f} GB free"
    if free < NO_SPACE:
        return failed("run directory", seen, "free some space, or name a folder on another disk with --out")
    if free < LITTLE_SPACE:
        return warning(
            "run directory", seen, "free some space before a long run, or name a folder on another disk with --out"
        )
    return ok("run directory", seen)


def private_keys(root: Path) -> Iterator[Finding]:
    """Private keys that killed runs left in their run directories under `root`."""
    if folders := stale_keys.stale(root):
        paths = " ".join(map(str, folders))
        yield warning("private keys", f"left by runs that were killed: {paths}", f"rm -r {paths}")


def _numbers(version: str) -> tuple[int, ...]:
    """The leading numbers of a version."""
    match = re.match(r"\d+(\.\d+)*", version)
    return tuple(int(part) for part in match[0].split(".")) if match else ()
