"""The reports of a running run, for all pages of a server."""

import time

from console.connect import observer
from console.web import facts
from console.web.facts import Status
from console.web.history import History
from fes import command_line
from fes.errors import Unavailable
from fes.protocol.report import Report
from fes.transport.bus import Bus

IDLE = 0.25
"""Time without a report after which the status is updated [s]."""


class Feed:
    """The latest report, the history, and the state of a run."""

    def __init__(self) -> None:
        self.latest: Report | None = None
        self.history = History()
        self.version = 0
        """Number of reports so far: a page that has shown this one is up to date."""
        self._heard = time.monotonic()
        self._is_over, self._left = False, ""

    @property
    def status(self) -> Status:
        """The state of the run now."""
        silence = time.monotonic() - self._heard
        return facts.live(silence, self._is_over, self.latest is not None, self._left)

    @property
    def known(self) -> float:
        """Time of the latest report [s]."""
        return self.latest.tick * self.latest.dt if self.latest is not None else 0.0

    def report(self, tick: int | None) -> Report | None:
        """The latest report: a running run has no other."""
        return self.latest

    def add(self, report: Report) -> None:
        """Add a report."""
        self.latest = report
        self.history.add(report)
        self.version += 1
        self._heard, self._is_over, self._left = time.monotonic(), False, ""

    def end(self, left: str = "") -> None:
        """Note the end of the run, with the reason of an early one."""
        self._is_over, self._left = not left, left


async def follow(bus: Bus, run: str, timeout: float, feed: Feed) -> None:
    """Add the reports of a run, and of those after it under the same name, until the task is cancelled.

    Raises Unavailable if no world appears within `timeout` [s].
    """
    while True:
        try:
            async for report in observer.reports(bus, run, timeout, IDLE):
                if report is not None:
                    feed.add(report)
            feed.end()
        except Unavailable as error:
            if feed.latest is None:
                raise
            feed.end(str(error))
        timeout = command_line.YEAR
