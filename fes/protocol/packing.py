"""Payloads of the messages of each tick, from fields whose arrays are bytes already.

A process that sends many messages makes the bytes of all of them at once, and cuts each message out of them. The
fields are those of `fes.protocol.messages`; ids are int32 and numbers float64, little-endian.
"""

from collections.abc import Iterable

from fes.protocol import wire


def pack_observation(
    tick: int, robot: int, pose: Iterable[float], in_range: bytes, reception: bytes, over: bool, since: int
) -> bytes:
    """The payload of an Observation whose arrays are bytes already."""
    return wire.pack(tick, robot, *pose, in_range, reception, over, since)


def pack_beacon(
    tick: int,
    robot: int,
    pose: Iterable[float],
    links: bytes,
    estimates: bytes,
    selected: bytes,
    statistics: bytes,
    declared: bytes,
) -> bytes:
    """The payload of a Beacon whose arrays are bytes already."""
    return wire.pack(tick, robot, *pose, links, estimates, selected, statistics, declared)


def pack_command(
    tick: int,
    robot: int,
    twist: Iterable[float],
    links: bytes,
    estimates: bytes,
    learnt: bytes,
    details: bytes,
    is_model_free: bool | None,
) -> bytes:
    """The payload of a Command whose arrays are bytes already."""
    return wire.pack(tick, robot, *twist, links, estimates, learnt, details, is_model_free)
