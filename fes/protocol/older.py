"""Payloads of protocol 3, as logs of that time have them, as payloads of this protocol, to the byte.

Protocol 3 had the messages of protocol 4, but for the last field of an Observation: each fix was of its tick. So a
recorded run can be executed again, and gives the same bytes.
"""

from fes.protocol import wire

PROTOCOL = 3
"""The protocol that is read in logs. On the bus it is refused."""

_OBSERVATION = 0x90 + 10
"""First byte of an Observation of that protocol: an array of 10, the version included."""


def renewed(payload: bytes) -> bytes:
    """A payload of protocol 3 as one of this protocol; any other payload as it is."""
    if payload[1:2] != bytes([PROTOCOL]):
        return payload
    return payload[:1] + bytes([wire.PROTOCOL]) + payload[2:]


def renewed_observation(payload: bytes, tick: int) -> bytes:
    """The payload of an Observation of `tick` as one of this protocol; any other payload as it is."""
    if payload[:2] != bytes([_OBSERVATION, PROTOCOL]):
        return payload
    return bytes([_OBSERVATION + 1, wire.PROTOCOL]) + payload[2:] + wire.pack(tick)[len(wire.pack()) :]
