"""The Report to observers, ten times per second of wall clock."""

import time

from fes.arrays.types import Bytes
from fes.protocol import keys, wire
from fes.protocol.report import encode_report
from fes.transport.bus import Bus
from world.metrics import report_builder
from world.metrics.collector import MetricsCollector


class ReportPublisher:
    """Publishes the state of a run, with the rate of ticks since the last Report."""

    def __init__(self, bus: Bus, run: str, name: str, metrics: MetricsCollector) -> None:
        """`run` names the run, `name` its scenario."""
        self._put = bus.declare_publisher(keys.report(run), "fes.Report", drop=True)
        self._name, self._metrics = name, metrics
        self._time = 0.0  # of the last Report [s; performance counter]
        self._ticks = metrics.link_errors.ticks

    def start(self) -> None:
        """Measure the rate of ticks from now on."""
        self._time = time.perf_counter()

    @property
    def is_due(self) -> bool:
        """True if it is time for a Report, and a tick has been recorded."""
        return time.perf_counter() - self._time >= report_builder.PERIOD and self._metrics.link_errors.ticks > 0

    def publish(self, alive: Bytes, elapsed: float) -> None:
        """Publish a Report, `elapsed` [s; wall clock] after tick 0; `alive` [n] is 1 for each robot with a token."""
        now, ticks = time.perf_counter(), self._metrics.link_errors.ticks
        rate = (ticks - self._ticks) / max(now - self._time, 1e-9)
        self._time, self._ticks = now, ticks
        payload = encode_report(report_builder.build(self._metrics, self._name, alive, elapsed, rate))
        if len(payload) <= wire.MAX_PAYLOAD:  # exceeded from about 8,000 robots on: observers then get no Report
            self._put(payload)
