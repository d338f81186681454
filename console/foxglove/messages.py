"""The topics of `run.mcap` whose messages follow from a Report, by the same functions as in the log.

A Report has no payloads of a tick, events, remarks or twists. So the topics `/scenario`, `/observations`,
`/beacons`, `/commands`, `/events`, `/log` and `/robot/<i>/state` are in the log only.
"""

from collections.abc import Iterator

from google.protobuf.message import Message

from fes.protocol.report import Report, encode_report
from fes.recording import viewer_topics
from fes.recording.viewer_topics import View
from fes.recording.writer import frames
from world.execution.recorder import MAX_VIEWED

BODIES = "/scene/robots"
"""The topic whose message does not change during a run."""


def time_of(report: Report) -> int:
    """Simulated time of a Report [ns], as in a log."""
    return round(report.tick * report.dt * 1e9)


def bodies(report: Report) -> Iterator[tuple[str, Message]]:
    """The topic of the robots' bodies, with its message at the start of a run; none in a team too large to view."""
    if len(report.alive) <= MAX_VIEWED:
        yield BODIES, viewer_topics.bodies(len(report.alive), viewer_topics.timestamp(0))


def of_report(report: Report) -> Iterator[tuple[str, Message]]:
    """Topics and messages of a Report, in the order of a log; only the Report itself in a team too large to view."""
    view = View.of_report(report) if len(report.alive) <= MAX_VIEWED else None
    time = viewer_topics.timestamp(time_of(report))
    return viewer_topics.messages(report.tick, encode_report(report), frames.numbers(report), view, time)
