"""Payloads of the messages of each tick, from fields whose arrays are bytes already.

A process that sends many messages makes the bytes of all of them at once, and cuts each message out of them. The
fields are those of `fes.protocol.messages`; ids are int32 and numbers float64, little-endian.
"""

from collections.abc import Iterable

from fes.protocol import wire

_ARRAY = 0x90
"""First byte of a msgpack array of fewer than 16 fields, without their number."""

_BEACON_FIELDS = 11


def beacon_head(tick: int) -> bytes:
    """The bytes with which every Beacon of a tick begins; its robot follows, as `robot_code` packs it."""
    return bytes([_ARRAY + _BEACON_FIELDS]) + wire.pack(tick)[1:]


def robot_code(robot: int) -> bytes:
    """The id of a robot as it stands in a message."""
    return wire.pack(robot)[len(wire.pack()) :]


def pack_observation(
    tick: int,
    robot: int,
    pose: Iterable[float],
    in_range: bytes,
    reception: bytes,
    over: bool,
    since: int,
    fixed: int,
) -> bytes:
    """The payload of an Observation whose arrays are bytes already."""
    return wire.pack(tick, robot, *pose, in_range, reception, over, since, fixed)


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
