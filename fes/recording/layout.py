"""Names and bounds of a log, on which its writer and its reader agree; docs/reference/log.md describes the format."""

from typing import NamedTuple

from fes.recording import records

NAME = "run.mcap"

SUMMARY = "fes.summary"
"""Name of the metadata at the end: the summary, and how the run ended."""

AT_ITS_END = "at its end"
"""Reason for the end of a run that ran all its ticks."""

MAX_JSON = records.SMALL
"""Longest JSON text [bytes]: a longer summary is only in summary.json."""


class TickPayloads(NamedTuple):
    """The payloads of one tick, in id order; an empty one stands for a missing one."""

    observations: list[bytes]
    beacons: list[bytes]
    commands: list[bytes]
