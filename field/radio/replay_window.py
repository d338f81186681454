"""Protection from replayed datagrams: each number of each start of a robot passes once. Pure.

Somebody who records datagrams can send them again, but cannot make new ones without the key. Three kinds of replay:
- A datagram of the robot's present start (boot id): it has passed already, or is too old, as in IPsec (RFC 4303,
  3.4.3).
- One of a former start: a robot's start that another has followed never passes again. The last BOOTS are remembered.
- One of a start that this receiver has never heard, or has forgotten. No one-way protocol without clocks in common
  can tell it from a robot that restarts. It passes only while the present start has been silent for TAKEOVER.

The limit: while a robot is silent, a recorded start that is unknown here can take its place. The robot's own beacons
are then refused until it restarts. Also, a datagram of the present start may be recorded elsewhere, and never heard
here. It passes while its number is less than WINDOW behind the highest, and counts as decoded. A new name for each
run, or a new key, makes all older records useless.
"""

from collections import deque

WINDOW = 64
"""Numbers below the highest that may still arrive: a longer delay than any beacon is good for."""

BOOTS = 32
"""Former starts that are remembered per robot."""

TAKEOVER = 500_000_000
"""Silence of a robot's start [ns] after which another start of the robot is accepted. A process takes longer to
restart. Of two processes that both claim to be the robot, the first remains."""

MAX_ROBOTS = 1024
"""Largest number of robots that are told apart: memory has a bound even without a key."""

REPEATED = "a number must not repeat"
TOO_OLD = f"a number must not be {WINDOW} behind the highest"
FORMER_START = "a former start of a robot must not return"
SECOND_START = "a robot must not have two starts at once"
CROWDED = f"a team must not have more than {MAX_ROBOTS} robots"
REPLAYS = (REPEATED, TOO_OLD, FORMER_START, SECOND_START, CROWDED)
"""Every rule that a datagram with a right code can break."""


class ReplayWindow:
    """The numbers that have passed, of each robot."""

    def __init__(self) -> None:
        self._robots: dict[int, _Robot] = {}

    def refusal(self, robot: int, boot: int, sequence: int, now: int) -> str:
        """The rule that a datagram breaks, one of REPLAYS; empty if it passes, which it then does not a second time.

        `now` is the time of its arrival on a monotonic clock [ns].
        """
        known = self._robots.get(robot)
        if known is None:
            if len(self._robots) >= MAX_ROBOTS:
                return CROWDED
            self._robots[robot] = _Robot(boot, sequence, now)
            return ""
        return known.refusal(boot, sequence, now)


class _Robot:
    """The present start of a robot, and its former ones."""

    def __init__(self, boot: int, sequence: int, now: int) -> None:
        self._former: deque[int] = deque(maxlen=BOOTS)
        self._begin(boot, sequence, now)

    def refusal(self, boot: int, sequence: int, now: int) -> str:
        """As `ReplayWindow.refusal`."""
        if boot == self._boot:
            return self._in_window(sequence, now)
        if boot in self._former:
            return FORMER_START
        if now - self._passed < TAKEOVER:
            return SECOND_START
        self._former.append(self._boot)
        self._begin(boot, sequence, now)
        return ""

    def _begin(self, boot: int, sequence: int, now: int) -> None:
        """Let a start be the present one, from its first datagram on."""
        self._boot, self._highest, self._seen, self._passed = boot, sequence, 1, now

    def _in_window(self, sequence: int, now: int) -> str:
        """The rule that a datagram of the present start breaks. Bit n of `_seen` stands for number highest - n."""
        behind = self._highest - sequence
        if behind >= WINDOW:
            return TOO_OLD
        if behind >= 0 and self._seen >> behind & 1:
            return REPEATED
        if behind >= 0:
            self._seen |= 1 << behind
        else:
            self._seen = (self._seen << min(-behind, WINDOW) | 1) & (1 << WINDOW) - 1
            self._highest = sequence
        self._passed = now
        return ""
