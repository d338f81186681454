"""The page of a recorded run in a browser: executed again once, and shown at any time by each browser."""

import asyncio
import functools
import time
from typing import NoReturn

from console.connect import index_source
from console.replay import recorded, reexecution
from console.replay.log import Log
from console.web import command
from console.web.facts import RunFacts, Status
from console.web.history import History
from fes import process
from fes.errors import FesError
from fes.protocol.report import Report, decode_report, encode_report
from fes.recording.layout import AT_ITS_END

CAPACITY = 2_000_000
"""Largest number of robot-ticks whose Reports are stored, about 130 bytes each."""

_BURST, _PAUSE = 0.05, 0.005  # s; executes ticks this long, then lets the pages have their turn


class RecordedRun:
    """The Reports of a log, as far as the run has been executed again."""

    def __init__(self, log: Log) -> None:
        self.history = History()
        self.version = 0
        self.status, self._end = Status("executing the log again"), _end(log)
        self._dt = log.scenario.run.dt
        self._stride = 1 + log.scenario.robots.number * log.scenario.ticks // CAPACITY
        self._reports = reexecution.reports(log)
        self._stored: list[bytes] = []
        """Encoded Reports of every stride-th tick."""
        self._first = 0

    @property
    def known(self) -> float:
        """Time up to which the run has been executed again [s]."""
        return (self._first + (len(self._stored) - 1) * self._stride) * self._dt if self._stored else 0.0

    def report(self, tick: int | None) -> Report | None:
        """The Report of a tick, or of the last known one before it."""
        if not self._stored:
            return None
        last = len(self._stored) - 1
        index = last if tick is None else min(max(0, (tick - self._first) // self._stride), last)
        return decode_report(self._stored[index])

    async def execute(self) -> None:
        """Execute the run again, beside the pages."""
        until = time.monotonic() + _BURST
        try:
            for report in self._reports:
                self._add(report)
                if time.monotonic() >= until:
                    await asyncio.sleep(_PAUSE)
                    until = time.monotonic() + _BURST
            self.status = self._end
        except FesError as error:
            self.status = Status(str(error), True)
            process.warn("fes", str(error))

    def _add(self, report: Report) -> None:
        if not self._stored:
            self._first = report.tick
        if (report.tick - self._first) % self._stride == 0:
            self._stored.append(encode_report(report))
            self.history.add(report)
            self.version += 1


def _end(log: Log) -> Status:
    """The status of a log that has been executed again."""
    if log.ended == AT_ITS_END:
        return Status("recorded")
    return Status("the log has no end" if log.ended is None else f"the run ended early: {log.ended}", True)


def show(log: Log, port: int, speed: float) -> NoReturn:
    """Serve the page of a log until a signal, and end the process."""
    command.require()
    for note in filter(None, (recorded.other_digits(log), log.complaint)):
        process.warn("fes", note)

    async def main() -> int:
        from console.web.slider import TimeSlider

        shown, run = RecordedRun(log), log.scenario.run
        about = RunFacts(str(log.path), run.seed, index_source.of(log.scenario))
        slider = functools.partial(TimeSlider, (log.scenario.ticks - 1) * run.dt, run.dt, speed)
        await command.serve(port, shown, about, shown.execute(), slider=slider)
        return process.SUCCESS

    process.leave("fes", main)
