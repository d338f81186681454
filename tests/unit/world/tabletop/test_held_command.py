"""The rules by which a driver obeys."""

import math
import struct

import pytest

from fes.ros import messages, topics
from fes.ros.topics import Topic
from world.config.hardware.tabletop import TabletopConfig
from world.tabletop.held_command import Arrival, HeldCommand

MARK = topics.attachment(Topic("rmw_zenoh", "/cmd_vel", "Twist"), 1, 5, bytes(16))


def arrival(time: float, kind: str = "Twist", twist: tuple[float, float] = (0.1, -0.5), mark: bytes = b"") -> Arrival:
    return Arrival(time, messages.write_twist(kind, *twist), mark)


def test_a_driver_without_a_timeout_holds_its_last_command_forever() -> None:
    held = HeldCommand(TabletopConfig())
    assert held.twist(0.0) == (0.0, 0.0)
    held.hear(arrival(1.0))
    assert held.twist(1.0) == held.twist(1e9) == (0.1, -0.5)


def test_a_driver_with_a_timeout_stops_after_it_and_obeys_the_next_command() -> None:
    held = HeldCommand(TabletopConfig(driver_timeout=0.5))
    assert held.twist(0.0) == (0.0, 0.0)
    held.hear(arrival(1.0))
    assert held.twist(1.5) == (0.1, -0.5)
    assert held.twist(1.6) == (0.0, 0.0)
    held.hear(arrival(2.0, twist=(0.2, 0.0)))
    assert held.twist(2.0) == (0.2, 0.0)


@pytest.mark.parametrize("kind", messages.TWIST_KINDS)
def test_a_message_of_another_type_is_ignored_and_the_last_command_held(kind: str) -> None:
    [other] = set(messages.TWIST_KINDS) - {kind}
    held = HeldCommand(TabletopConfig.model_validate({"command_type": kind}))
    held.hear(arrival(1.0, kind))
    held.hear(arrival(2.0, other, (0.2, 0.2)))
    assert held.twist(2.0) == (0.1, -0.5)
    assert (held.obeyed, held.ignored) == (1, 1)


@pytest.mark.parametrize(
    "payload", [b"", b"\0\1\0\0", b"\0\1\0\0" + struct.pack("<6d", math.nan, 0, 0, 0, 0, 0), b"\xff" * 52]
)
def test_bytes_that_are_not_a_twist_are_ignored(payload: bytes) -> None:
    held = HeldCommand(TabletopConfig())
    held.hear(Arrival(1.0, payload, b""))
    assert held.twist(1.0) == (0.0, 0.0)
    assert held.ignored == 1


@pytest.mark.parametrize(("mark", "obeyed"), [(MARK, 1), (b"", 0), (MARK[:-1], 0)])
def test_only_rmw_zenoh_demands_an_attachment(mark: bytes, obeyed: int) -> None:
    for style, count in (("rmw_zenoh", obeyed), ("ros2dds", 1)):
        held = HeldCommand(TabletopConfig.model_validate({"style": style}))
        held.hear(arrival(1.0, mark=mark))
        assert held.obeyed == count
