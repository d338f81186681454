"""The beacons that a world keeps a log of: one that did not come is missing, and nothing was dropped."""

import logging
from collections import deque

import numpy as np
import pytest

from fes import wire
from fes.complaints import Complaints
from world.ears import Ears

Sample = tuple[str, bytes | None]


class Boxes:
    """Stands for the bus: a mailbox of each robot."""

    def __init__(self, boxes: list[list[bytes]]) -> None:
        self._boxes = iter(boxes)

    def mailbox(self, key: str) -> "Box":
        return Box((key, payload) for payload in next(self._boxes))


class Box(deque[Sample]):
    """Samples that wait."""

    def take(self) -> Sample | None:
        return self.popleft() if self else None


def test_a_beacon_that_did_not_come_is_said_to_be_missing_once_and_counted(
    caplog: pytest.LogCaptureFixture,
) -> None:
    complaints = Complaints(logging.getLogger("world"))
    beacons = [wire.pack(tick, 0) for tick in (53, 55)]
    ears = Ears(Boxes([beacons, []]), "test", 2, complaints)  # type: ignore[arg-type]
    for tick, speaks in ((53, [True, True]), (54, [True, True]), (55, [True, False])):
        heard = ears.heard(tick, np.array(speaks))
        assert heard == [beacons[(tick - 53) // 2] if tick != 54 else b"", b""]
    complaints.log_total()
    assert [record.getMessage() for record in caplog.records] == [
        "no beacon of robot 1 came for tick 53 (further ones of this kind are counted, not shown)",
        "missing: beacons in the log x3",  # of robot 1 twice, and of robot 0 at tick 54
    ]
    assert not complaints.counts
