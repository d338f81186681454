"""The wall clock against the monotonic clock."""

import time

LOOKS = 3
"""Number of looks at both clocks: a process that loses its processor in one of them reads them at two moments."""


def ahead() -> int:
    """Wall clock minus monotonic clock [ns], from the shortest of LOOKS looks at both."""
    looks = []
    for _ in range(LOOKS):
        before = time.monotonic_ns()
        wall = time.time_ns()
        looks.append((time.monotonic_ns() - before, wall - before))
    return min(looks)[1]
