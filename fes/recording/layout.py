"""Names and bounds of a log, on which its writer and its reader agree; docs/reference/log.md describes the format."""

import struct
from itertools import pairwise
from typing import NamedTuple

from fes.recording import records

NAME = "run.mcap"

ROBOT = "/robot"
"""Topic of the first message in the log of a robot, which the log of a run does not have."""

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


class PackedPayloads(NamedTuple):
    """The same payloads one after the other, as the compiled core writes them."""

    data: bytes
    ends: bytes
    """The end of each payload, as int64 [3 n]."""

    def unpacked(self) -> TickPayloads:
        """The payloads one by one.

        >>> PackedPayloads(b"oobc", struct.pack("=6q", 1, 2, 3, 3, 4, 4)).unpacked()
        TickPayloads(observations=[b'o', b'o'], beacons=[b'b', b''], commands=[b'c', b''])
        """
        count = len(self.ends) // 8
        parts = [self.data[a:b] for a, b in pairwise((0, *struct.unpack(f"={count}q", self.ends)))]
        n = count // 3
        return TickPayloads(parts[:n], parts[n : 2 * n], parts[2 * n :])
