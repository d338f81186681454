"""The datagram of a beacon between real robots: a beacon's payload with its sender, its number and a code.

Its bytes, little-endian: magic [4], version [1], hash of the run's name [8], robot [4], boot id [8], sequence [4],
the payload, and the first 16 bytes of HMAC-SHA256 (RFC 2104) over all before. The key is the team's. An empty key
leaves a checksum, which authenticates no sender.

`opened` raises MessageError, and nothing else, on any bytes. Its `rule` is one of REFUSALS.
"""

import hashlib
import hmac
import struct
from functools import lru_cache
from typing import NamedTuple

from fes.errors import MessageError
from fes.protocol import wire

VERSION = 1
"""Version of the datagram: increase it with each change of its bytes."""

LONGEST = 1399
"""Longest datagram [bytes]: with the headers of IP and UDP it fits the frame of any network undivided."""

MAX_BOOT = 2**64 - 1
MAX_SEQUENCE = 2**32 - 1

WRONG_LENGTH = f"a datagram has up to {LONGEST} bytes, and a head"
FOREIGN = "a datagram begins with the magic of a beacon"
WRONG_VERSION = f"the datagram must have version {VERSION}"
OTHER_RUN = "the datagram must be of this run"
FORGED = "the code must fit the key"
WRONG_ROBOT = wire.BAD_ID
REFUSALS = (WRONG_LENGTH, FOREIGN, WRONG_VERSION, OTHER_RUN, FORGED, WRONG_ROBOT)
"""Every rule that a datagram can break."""

_MAGIC = b"fesB"
_HEAD = struct.Struct("<4sB8sIQI")
_CODE = 16  # bytes; a guess succeeds once in 2^128

LONGEST_PAYLOAD = LONGEST - _HEAD.size - _CODE
"""Longest payload in a datagram [bytes]."""

_NAME = "Sealed"


class Sealed(NamedTuple):
    """A payload whose code was checked, and its sender."""

    robot: int
    boot: int
    """A number that the sender's process has drawn, from 0 to MAX_BOOT: each start has another."""
    sequence: int
    """Number of the datagram since that start, from 0 to MAX_SEQUENCE."""
    payload: bytes


def seal(key: bytes, run: str, robot: int, boot: int, sequence: int, payload: bytes) -> bytes:
    """The datagram with a payload; raises MessageError for a number out of bounds or a payload that is too long."""
    wire.robot_id(_NAME, robot)
    wire.check(_NAME, 0 <= boot <= MAX_BOOT, f"the boot id must be from 0 to {MAX_BOOT}", boot)
    is_number = 0 <= sequence <= MAX_SEQUENCE
    wire.check(_NAME, is_number, f"the sequence must be from 0 to {MAX_SEQUENCE}", sequence)
    is_short = len(payload) <= LONGEST_PAYLOAD
    wire.check(_NAME, is_short, f"a payload must have at most {LONGEST_PAYLOAD} bytes", len(payload))
    body = _HEAD.pack(_MAGIC, VERSION, _run_hash(run), robot, boot, sequence) + payload
    return body + _code(key, body)


def opened(key: bytes, run: str, datagram: bytes) -> Sealed:
    """The payload of a datagram of this run, with a code of this key."""
    robot, boot, sequence = _numbers(datagram, run)
    body = datagram[:-_CODE]
    if not hmac.compare_digest(datagram[-_CODE:], _code(key, body)):
        raise MessageError(_NAME, FORGED)
    if robot > wire.MAX_ID:  # only a holder of the key can send it
        raise MessageError(_NAME, WRONG_ROBOT, str(robot))
    return Sealed(robot, boot, sequence, body[_HEAD.size :])


def sender(datagram: bytes) -> int | None:
    """The robot that a datagram of any run names; None for other bytes. The code is not checked."""
    if not _HEAD.size + _CODE <= len(datagram) <= LONGEST:
        return None
    magic, version, _, robot, _, _ = _HEAD.unpack_from(datagram)
    return robot if magic == _MAGIC and version == VERSION and robot <= wire.MAX_ID else None


def _numbers(datagram: bytes, run: str) -> tuple[int, int, int]:
    """Robot, boot id and sequence of a datagram of this run, with any code."""
    if not _HEAD.size + _CODE <= len(datagram) <= LONGEST:
        raise MessageError(_NAME, WRONG_LENGTH, str(len(datagram)))
    magic, version, run_hash, robot, boot, sequence = _HEAD.unpack_from(datagram)
    if magic != _MAGIC:
        raise MessageError(_NAME, FOREIGN, repr(magic))
    if version != VERSION:
        raise MessageError(_NAME, WRONG_VERSION, str(version))
    if run_hash != _run_hash(run):
        raise MessageError(_NAME, OTHER_RUN, run)
    return robot, boot, sequence


@lru_cache(maxsize=16)
def _run_hash(run: str) -> bytes:
    """The first 8 bytes of SHA-256 of the run's name."""
    return hashlib.sha256(run.encode()).digest()[:8]


def _code(key: bytes, body: bytes) -> bytes:
    """The code of a datagram's other bytes."""
    return hmac.digest(key, body, "sha256")[:_CODE]
