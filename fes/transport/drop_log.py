"""Dropped and missing messages: counted, and logged once per kind."""

import logging
from collections import Counter

from fes.errors import MessageError
from fes.system.output import printable

MAX_KINDS = 100
"""Default number of kinds that are counted separately."""

LONGEST_LINE = 300
"""Longest line and longest kind [characters]; a key may have 65,535 bytes of any content."""


class DropLog:
    """Messages that were dropped, by kind. Bad input is a line in the log, never the end of a tick loop."""

    def __init__(self, logger: logging.Logger, most: int = MAX_KINDS, rest: str = "other") -> None:
        """At most `most` kinds are counted separately; further kinds are counted as `rest`."""
        self._logger = logger
        self._most, self._rest = most, rest
        self.counts: Counter[str] = Counter()
        self.missing: Counter[str] = Counter()
        """Number of missing messages by kind."""

    def reject(self, kind: str, line: str) -> None:
        """Count a dropped message; the first of its `kind` is logged with `line`. A sender may influence both."""
        kind, further = shown(kind), "further ones of this kind"
        if kind not in self.counts and len(self.counts) >= self._most:
            kind, further = self._rest, "further kinds"
        self.counts[kind] += 1
        if self.counts[kind] == 1:
            self._logger.warning("dropped %s (%s are counted, not shown)", shown(line), further)

    def unread(self, key: str, error: MessageError) -> None:
        """Count a message that cannot be used, by the rule it breaks."""
        self.reject(f"{error.schema}: {error.rule}", f"{key}: {error}")

    def note_missing(self, kind: str, line: str) -> None:
        """Count a missing message; the first of its `kind`, one of a few fixed words, is logged with `line`."""
        self.missing[kind] += 1
        if self.missing[kind] == 1:
            self._logger.warning("%s (further ones of this kind are counted, not shown)", shown(line))

    def log_total(self, overflow: int = 0, strangers: int = 0) -> None:
        """Log one line with all counts, if there are any.

        `overflow` messages met a full queue; `strangers` came from a process that was not accepted.
        """
        if overflow:
            self.counts["no room"] += overflow
        if strangers:
            self.counts["of a process that was not accepted"] += strangers
        for what, counts in (("dropped messages", self.counts), ("missing", self.missing)):
            if counts:
                total = ", ".join(f"{kind} x{count}" for kind, count in counts.most_common(8))
                self._logger.warning("%s: %s", what, total)


def shown(line: str) -> str:
    """Text that a sender can influence, as one line of a log: printable, and of bounded length.

    >>> shown("key\\nforged line: rule")
    'key\\\\nforged line: rule'
    """
    shown = printable(line[:LONGEST_LINE])
    return shown if len(line) <= LONGEST_LINE else shown + "..."
