"""Reading of the beacons in a peer's mailbox, in any order."""

import logging
from types import SimpleNamespace

import numpy as np

from agents.runtime.beacon_subscriptions import BeaconSubscriptions
from fes.protocol import keys, messages
from fes.protocol.messages import Beacon
from fes.transport.drop_log import DropLog

NOTHING = np.zeros(0)
NOBODY = np.zeros(0, dtype=np.int64)


def beacon(tick: int, x: float = 0.0, robot: int = 5) -> bytes:
    return messages.encode_beacon(
        Beacon(tick, robot, (x, 0.0, 0.0), NOBODY, NOTHING, NOBODY.astype(np.uint8), NOTHING)
    )


def heard(*rounds: tuple[int, list[bytes | None]]) -> tuple[list[list[tuple[int, float]]], DropLog]:
    """For each tick that is asked for, with what has come until then: tick and x of the beacons that are heard."""
    waiting: list[bytes | None] = []
    key, drops = keys.beacon("test", 5), DropLog(logging.getLogger("test"))
    box = SimpleNamespace(take=lambda: (key, waiting.pop(0)) if waiting else None)
    radio = BeaconSubscriptions(SimpleNamespace(mailbox=lambda key: box), "test", "0", drops)  # type: ignore[arg-type]
    radio.update({5})
    result = []
    for tick, came in rounds:
        waiting += came
        result.append([(one.tick, one.pose[0]) for one in radio.heard(tick)])
    return result, drops


def test_an_early_beacon_is_kept_for_its_tick_and_a_second_one_does_not_replace_it() -> None:
    result, drops = heard((0, [beacon(1, 1.0), beacon(1, 2.0), beacon(0, 3.0)]), (1, [beacon(1, 4.0)]), (2, []))
    assert result == [[(0, 3.0)], [(1, 1.0)], []]
    assert not drops.counts


def test_old_beacons_are_dropped_and_junk_or_future_ones_are_counted() -> None:
    junk = [b"\xc1", None, beacon(3, robot=6), beacon(9), beacon(2)]
    result, drops = heard((3, [*junk, beacon(3, 1.0), beacon(3, 2.0)]), (4, [beacon(4)]))
    assert result == [[(3, 1.0)], [(4, 0.0)]]
    assert drops.counts == {
        "Beacon: is not msgpack (FormatError)": 1,
        "Beacon: a deletion is not a beacon": 1,
        "Beacon: came on another robot's key": 1,
        "Beacon: from the future": 1,
    }
