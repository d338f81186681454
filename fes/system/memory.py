"""Memory that a process of this machine can still take."""

import os
import resource
from pathlib import Path

MEMINFO = Path("/proc/meminfo")
STATM = Path("/proc/self/statm")
CGROUP = Path("/sys/fs/cgroup")


def available() -> int:
    """Memory available without swapping [bytes]: the least that machine, container and limit (ulimit -v) allow."""
    return max(0, min(_machine(), _container(), _limit()))


def gigabytes(size: float) -> str:
    """A size [bytes] as it is printed.

    >>> gigabytes(8_997_000_000)
    '9.0 GB'
    """
    return f"{size / 1e9:,.1f} GB"


def _machine() -> int:
    """Memory that the kernel reports as available [bytes]; all of it where the kernel does not report it (macOS)."""
    try:
        lines = MEMINFO.read_text(encoding="ascii").splitlines()
        return next(1024 * int(line.split()[1]) for line in lines if line.startswith("MemAvailable:"))
    except (OSError, ValueError, StopIteration):
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")


def _container() -> int:
    """Unused part of the limit of this process's control group (version 2) [bytes]; cached files count as unused."""
    try:
        limit, used = ((CGROUP / f"memory.{name}").read_text(encoding="ascii") for name in ("max", "current"))
        return int(limit) - max(0, int(used) - _cached())
    except (OSError, ValueError):  # no such group, or "max": no limit
        return 2**63


def _cached() -> int:
    """Files that the control group caches, and that the kernel drops when memory is wanted [bytes]."""
    try:
        lines = (CGROUP / "memory.stat").read_text(encoding="ascii").splitlines()
        sizes = {name: int(size) for name, size in (line.split() for line in lines)}
    except (OSError, ValueError):
        return 0
    return sizes.get("inactive_file", 0) + sizes.get("active_file", 0)


def _limit() -> int:
    """Unused part of the limit on this process's address space [bytes]."""
    soft, _ = resource.getrlimit(resource.RLIMIT_AS)
    if soft == resource.RLIM_INFINITY:
        return 2**63
    try:
        taken = int(STATM.read_text(encoding="ascii").split()[0]) * os.sysconf("SC_PAGE_SIZE")
    except (OSError, ValueError):
        taken = 0
    return soft - taken
