"""Values of each kind of message, one of each."""

import math
import struct
from typing import Any

import msgpack


def int32(*ids: int) -> bytes:
    return struct.pack(f"<{len(ids)}i", *ids)


def int64(*numbers: int) -> bytes:
    return struct.pack(f"<{len(numbers)}q", *numbers)


def float64(*numbers: float) -> bytes:
    return struct.pack(f"<{len(numbers)}d", *numbers)


PROTOCOL = 4

# The layouts, packed by hand: version, then the fields; robot 4 at tick 7 with the peers 2 and 9.
PLAIN: dict[str, list[Any]] = {
    "Observation": [PROTOCOL, 7, 4, 1.0, 2.0, 0.5, int32(2, 9), b"\2\1", False, 3, 5],
    "Beacon": [PROTOCOL, 7, 4, 1.0, 2.0, 0.5, int32(2, 9), float64(60.0, 70.0), b"\1\0", float64(1.0), b"\7\0"],
    "Command": [
        *(PROTOCOL, 7, 4, 1.5, -0.5, int32(2, 9), float64(60.0, 70.0)),
        *(float64(-2.0, -2.1, 3.0, 3.1), float64(0.25), True),
    ],
    "Join": [PROTOCOL, [4, 5], 12345, "arithmetic 5c62e091b8c0"],
    "Recall": [PROTOCOL, 7],
    "Change": [PROTOCOL, "channel.reference_snr", "5000000.0"],
    "Effect": [PROTOCOL, "channel.reference_snr", "5000000.0", 7, 68.0, False],
    "About": [PROTOCOL, "0.1.0", "1.10.2", 10, 1.8e9],
    "Report": [
        *(PROTOCOL, "pair", 7, 9, [0.02, 68.0, 1.0, 50.0, *[math.nan, math.inf] * 4], b"\1\0"),
        *(float64(*range(6)), int32(0), int32(1), [float64(math.nan)] * 10, 8, 6, True),
        [struct.pack("<2q", 3, 0), struct.pack("<2q", 1, 0)],
    ],
}
PLAIN["RobotReport"] = [
    *(PROTOCOL, 77, 2.5, 0.02, [1.0, 2.0, 0.5], 0.04, msgpack.packb(PLAIN["Command"]), 75.0, int32(2, 9)),
    *([int64(90, 80), int64(10, 19), int64(0, 1)], float64(61.0, math.nan), "held", "no permit"),
]
PLAIN["Permit"] = [PROTOCOL, 5, 7, 12_000_000_000]
PLAIN["Start"] = [PROTOCOL, 12_000_000_000]
PLAIN["GateStatus"] = [PROTOCOL, 4, "stopped", "fence", [1.0, 2.0, 0.5], 0.04, [0.0, 0.0], 90, 1, 12_000_000_000]

TEAM: list[Any] = [[0.5, 0.69, math.nan], int32(1), int32(-1, 0), int32(2, 0)]
"""The last field of a Report with the team index, of two robots."""
