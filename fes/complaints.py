"""What came that should not have come: counted, and logged once a kind."""

import logging
from collections import Counter

MAX_KINDS = 100


class Complaints:
    """Messages that were dropped, by kind. Bad input is a line in the log, never the end of a tick loop."""

    def __init__(self, logger: logging.Logger) -> None:
        self._logger = logger
        self.counts: Counter[str] = Counter()

    def add(self, kind: str, line: str) -> None:
        """Count one; the first of its kind is logged with `line`."""
        if kind not in self.counts and len(self.counts) >= MAX_KINDS:
            kind = "other"
        self.counts[kind] += 1
        if self.counts[kind] == 1:
            self._logger.warning("dropped %s (further ones of this kind are counted, not shown)", line)

    def log_total(self, overflow: int = 0) -> None:
        """One line with the counts, if there are any; `overflow` messages found no room to wait."""
        if overflow:
            self.counts["no room"] += overflow
        if self.counts:
            total = ", ".join(f"{kind} x{count}" for kind, count in self.counts.most_common(8))
            self._logger.warning("dropped messages: %s", total)
